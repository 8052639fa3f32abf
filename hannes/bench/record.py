"""`hannes record`: an experiment's command sent to a board, its answer made a recording."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from hannes.bench.events import About
from hannes.bench.finish import read_rows, recording
from hannes.bench.profile_check import require_within
from hannes.bench.reader import Link
from hannes.bench.session import Session, session
from hannes.core.errors import BadInput
from hannes.core.recording.recording import Recording
from hannes.simulation.experiment.experiment import Experiment
from hannes.simulation.experiment.load import load_experiment
from hannes.simulation.experiment.writer import experiment_toml
from hannes.simulation.hand.hand_file import hand_toml

RAW = ".rawlog"
LONGEST = 1e5  # s of an experiment that a log may name
STREAM = 0.005  # s between set points where a board takes no profile

Progress = Callable[[str], None]


@dataclass(frozen=True)
class Recorded:
    """A recording from a board, and the raw log that it was made of."""

    recording: Recording
    raw: Path
    about: About | None
    stopped: bool  # the stop was seen in the telemetry


def record(
    experiment: str, link: Link, raw: str | Path, progress: Progress = lambda text: None
) -> Recorded:
    """Send an experiment's command to a board and return what came back.

    `raw` is where the bytes are kept as they came; it must not exist. Raises BadInput where the
    board cannot be reached or refuses, ComputationFailed where it was stopped on the way.
    """
    variants = load_experiment(experiment)
    if len(variants) > 1:
        raise BadInput(f"{experiment}: asks for {len(variants)} runs; record them one at a time")
    (variant,) = variants
    if Path(raw).exists():
        raise BadInput(f"{raw}: is there already; a raw log is never written over")
    require_within(variant.hand, variant.experiment, progress=progress)
    about = {
        "duration": variant.experiment.duration,
        "experiment": experiment_toml(variant.hand, variant.experiment),
        "hand": hand_toml(variant.hand),
    }
    with session(link, raw, about) as talk:
        for note in talk.reader.notes:
            progress(note)
        board = talk.hello()
        progress(f"{link.port}: {board.firmware}, {len(board.channels)} channels")
        run_command(talk, variant.experiment)
        if not (stopped := talk.close()):
            progress(talk.stop_in_words())
    return Recorded(recover(raw), Path(raw), board, stopped)


def run_command(talk: Session, experiment: Experiment) -> None:
    """Run the experiment's reference: as a profile, or as set points where the board has none."""
    points = command_points(experiment)
    if talk.speaker.profile(points):
        talk.profile(points)
        talk.run_to_end(experiment.duration)
    else:
        stream(talk, experiment)


def command_points(experiment: Experiment) -> list[tuple[float, float]]:
    """Corners of the reference (time [s], angle [rad]) up to the experiment's end."""
    import numpy as np

    times, values = experiment.reference.knots
    end = experiment.duration
    points = [(float(t), float(v)) for t, v in zip(times, values, strict=True) if t < end]
    if not points or points[0][0] > 0.0:
        points.insert(0, (0.0, float(np.interp(0.0, times, values))))
    points.append((end, float(np.interp(end, times, values))))
    return points


def stream(talk: Session, experiment: Experiment) -> None:
    """Send set points as time goes by; the host's jitter is in the motion."""
    import numpy as np

    times, values = experiment.reference.knots
    began = time.monotonic()
    while (since := time.monotonic() - began) < experiment.duration:
        talk.reader.send(talk.speaker.set_point(float(np.interp(since, times, values))))
        talk.wait(lambda: False, STREAM)


def recover(raw: str | Path, progress: Progress = lambda text: None) -> Recording:
    """Return the recording in a raw log, of a recorder that was killed for instance.

    It ends with the experiment that the log names, or where the log is cut off or damaged:
    `progress` is given that in words. Raises BadInput where no sample is in it.
    """
    rows = read_rows(raw)
    if rows.left_out:
        progress(f"{raw}: {rows.left_out}")
    texts = {key: _text(rows.log.get(key)) for key in ("experiment", "hand")}
    duration = rows.log.get("duration")
    known = isinstance(duration, int | float) and 0.0 < duration < LONGEST
    return recording(rows, duration=duration if known else None, plant="hand", **texts)


def _text(value: object) -> str:
    return value if isinstance(value, str) else ""
