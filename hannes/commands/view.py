"""`hannes view`: recordings as a hand in motion, in one page; and stills of it."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from hannes.core.errors import BadInput
from hannes.core.io.atomic_files import write_bytes, write_text
from hannes.core.io.outputs import reserved
from hannes.core.recording.recording import Recording
from hannes.report.viewer.notes import notes
from hannes.report.viewer.page import page
from hannes.report.viewer.replay import Replay, replay, without_effects
from hannes.report.viewer.scene import Scene, scene
from hannes.report.viewer.still import still_files
from hannes.simulation.experiment.load import load_experiment
from hannes.simulation.experiment.variants import Variant
from hannes.simulation.experiment.writer import experiment_toml
from hannes.simulation.hand.hand import Hand
from hannes.simulation.hand.hand_file import load_hand

SHOWN = ("position", "current", "duty", "force")


def view(
    files: Sequence[str | Path],
    out: str | Path = "results/view.html",
    *,
    hands: Sequence[str | Path] = (),
    experiments: Sequence[str | Path] = (),
    stills: Sequence[float] = (),
    force: bool = False,
) -> dict[str, Any]:
    """Write a page that shows one recording, or two of them in one picture; return what it shows.

    A recording has no joint angles: it is drawn by a simulation of its experiment with its own
    hand, or with `hands` (hand.toml files) and `experiments` (shipped names or .toml files), one
    for all recordings or one for each. A hand with effects is simulated without them too. Both
    recordings begin together, whatever their clocks say. stills: times [s] of which to write an
    SVG and a PNG beside the page. `force`: files of another command are replaced, too. Raises
    BadInput for what is no recording of a hand, ComputationFailed where a simulation does not end.
    """
    target = Path(out)
    if target.suffix.lower() != ".html":
        raise BadInput(f"{out}: expected a file named .html for the page")
    moments = list(dict.fromkeys(stills))
    stilled = [_still_place(target, time, each) for time in moments for each in (".svg", ".png")]
    named = [each for each in experiments if str(each).endswith(".toml")]
    with reserved("view", [target, *stilled], [*files, *hands, *named], force=force):
        replays, scenes = _scenes(files, hands, experiments, moments)
        bare = without_effects(replays[-1])
        without = _bare(bare, scenes[-1], moments) if bare else None
        _check_times(moments, scenes)
        text = page(_title(scenes), scenes, without)
        target.parent.mkdir(parents=True, exist_ok=True)
        write_text(target, text)
        drawn = [*scenes, without] if without else scenes
        return {
            "out": str(target),
            "bytes": target.stat().st_size,
            "recordings": [{"name": each.name, "note": each.note} for each in drawn],
            "stills": [path for time in moments for path in _still(target, drawn, time)],
        }


def _scenes(
    files: Sequence[str | Path],
    hands: Sequence[str | Path],
    experiments: Sequence[str | Path],
    moments: Sequence[float],
) -> tuple[list[Replay], list[Scene]]:
    """The recordings with the simulations that draw them, and what is to be said of both."""
    recordings = [Recording.read(each) for each in _few(files)]
    chosen = _each([(Path(each).name, load_hand(each)) for each in hands], recordings, "hands")
    planned = _each([_planned(each) for each in experiments], recordings, "experiments")
    names = _names([Path(each) for each in files])
    replays: list[Replay] = []
    scenes: list[Scene] = []
    for k, recording in enumerate(recordings):
        ran, drawn_by = _replay(files[k], recording, chosen[k], planned[k])
        shift = _shift(ran, replays)
        made = scene(ran, names[k], drawn_by, [each + shift for each in moments])
        named = planned[k].experiment.title if planned[k] else ""
        note = notes(ran, made, str(files[k]), named)
        if shift:
            note += f"; its clock begins at {made.time[0]:g} s, here it begins with the first"
        replays.append(ran)
        scenes.append(replace(made, note=note, time=made.time - shift, simulated=_kept(made)))
    return replays, scenes


def _few(files: Sequence[str | Path]) -> Sequence[str | Path]:
    if not 1 <= len(files) <= 2:
        raise BadInput(f"{len(files)} recordings: a page shows one, or two in one picture")
    return files


def _each(given: Sequence[Any], recordings: Sequence[Recording], what: str) -> list[Any]:
    """What was given for each recording: one for all, one for each, or None."""
    if len(given) not in (0, 1, len(recordings)):
        raise BadInput(
            f"{len(given)} {what} for {len(recordings)} recordings: give one, or as many"
        )
    return [*given, *given][: len(recordings)] or [None] * len(recordings)


def _planned(name: str | Path) -> Variant:
    asked = load_experiment(name)
    if len(asked) > 1:
        raise BadInput(
            f"{name}: stands for {len(asked)} simulations; name the experiment of one recording"
        )
    return asked[0]


def _replay(
    file: str | Path,
    recording: Recording,
    given: tuple[str, Hand] | None,
    planned: Variant | None,
) -> tuple[Replay, str]:
    """Simulate a recording; and name the hand where it is not its own."""
    own = bool(recording.hand) or recording.source == "simulated"
    drawn_by, hand = given if given else ("" if own else "the shipped hand", None)
    if planned is not None:
        if hand is None and not recording.hand:
            hand = planned.hand
            drawn_by = "the experiment's hand"
        text = experiment_toml(planned.hand, planned.experiment)
        recording = replace(recording, experiment=text)
        drawn_by = drawn_by or "its own hand"
    try:
        return replay(recording, hand), drawn_by
    except BadInput as error:
        raise BadInput(f"{file}: {error}") from None


def _shift(shown: Replay, before: Sequence[Replay]) -> float:
    """By how much a recording's clock is ahead of the first one's [s]: both begin together."""
    if not before:
        return 0.0
    first, second = before[0].recording.time, shown.recording.time
    apart = float(second[0] - first[0])
    return apart if abs(apart) > 0.5 * float(first[1] - first[0]) else 0.0


def _kept(made: Scene) -> dict[str, Any]:
    """Simulated channels to show: what was recorded by the same simulation is there already."""
    kept = ("leader_tension",) if made.own else (*SHOWN, "leader_tension")
    return {each: values for each, values in made.simulated.items() if each in kept}


def _names(files: Sequence[Path]) -> list[str]:
    """Distinct names of the files: their own, with the folder where these are equal."""
    stems = [each.name.split(".")[0] for each in files]
    if len(set(stems)) == len(stems):
        return stems
    folders = [
        f"{each.resolve().parent.name}/{stem}" for each, stem in zip(files, stems, strict=True)
    ]
    return folders if len(set(folders)) == len(folders) else [f"{stems[0]} 1", f"{stems[1]} 2"]


def _title(scenes: Sequence[Scene]) -> str:
    """The experiments' titles with the recordings' names, once where they are one."""
    titled = [f"{each.title} ({each.name})" if each.title else each.name for each in scenes]
    if len({each.title for each in scenes}) == 1 and scenes[0].title:
        return f"{scenes[0].title} ({', '.join(each.name for each in scenes)})"
    return ", ".join(titled)


def _bare(shown: Replay, own: Scene, moments: Sequence[float]) -> Scene:
    """The same simulated without effects: nobody recorded it."""
    shift = float(shown.recording.time[0] - own.time[0])
    made = scene(shown, f"{own.name} without", own.drawn_by, [each + shift for each in moments])
    kept = {
        name: each for name, each in made.simulated.items() if name in (*SHOWN, "leader_tension")
    }
    note = f"simulated without {', '.join(each.name for each in shown.hand.effects)}"
    return replace(made, note=note, time=own.time, recorded={}, simulated=kept)


def _check_times(stills: Sequence[float], scenes: Sequence[Scene]) -> None:
    first = min(each.time[0] for each in scenes)
    last = max(each.time[-1] for each in scenes)
    for time in stills:
        if not first <= time <= last:
            raise BadInput(
                f"no still at {time:g} s: the recording goes from {first:g} to {last:g} s"
            )


def _still_place(target: Path, time: float, suffix: str) -> Path:
    """Name of a still: all digits of its time, so that two times are two files."""
    short = f"{time:g}"
    words = short if float(short) == time else repr(time)
    return target.with_name(f"{target.stem}-{words}s{suffix}")


def _still(target: Path, scenes: Sequence[Scene], time: float) -> list[str]:
    """Write one moment beside the page; return the names of the files."""
    found = []
    for suffix, content in still_files(scenes[:2], time).items():
        path = _still_place(target, time, suffix)
        write_bytes(path, content)
        found.append(str(path))
    return found
