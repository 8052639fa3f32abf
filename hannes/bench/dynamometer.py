"""A hand dynamometer beside the board: its force merged into the recording by the onset of contact.

Two clocks meet at one event that both see: the force leaves its rest, and the current rises above
what free closing takes (the touch of `hannes/recognition/features.py`). Sources: the CSV export of
Vernier's programs, or a live device (dynamometer_live.py).
"""

import csv
import json
import re
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from hannes.core.errors import BadInput
from hannes.core.io import atomic_files
from hannes.core.io.bounded import lines
from hannes.core.io.json_text import table
from hannes.core.recording.recording import Recording
from hannes.recognition.features import NAMES
from hannes.recognition.windowing import Windowing

TOUCHED = 5.0  # N above rest at which the force counts as begun: the current shows no less
REST = 5  # samples of rest that are wanted before it
TIMES = {"s": 1.0, "ms": 1e-3, "min": 60.0}
COLUMN = re.compile(r"(time|force)\b[^()]*\(([^()]*)\)", re.IGNORECASE)
SINCE = NAMES.index("since")


@dataclass(frozen=True)
class ForceLog:
    """Force [N] over the dynamometer's own time [s], both (n,); time rises."""

    time: np.ndarray
    force: np.ndarray

    def onset(self) -> tuple[float, float]:
        """Time [s] at which the force leaves its rest, and that rest [N]; BadInput without one."""
        early = self.force[: max(REST, self.force.size // 20)]
        rest = float(np.median(early))
        above = np.flatnonzero(self.force > rest + TOUCHED)
        if not above.size or above[0] < REST:
            raise BadInput(
                f"the dynamometer's force has no onset: expected {REST} samples at rest, then "
                f"{TOUCHED:g} N more"
            )
        k = int(above[0])
        share = (rest + TOUCHED - self.force[k - 1]) / (self.force[k] - self.force[k - 1])
        return float(self.time[k - 1] + share * (self.time[k] - self.time[k - 1])), rest


def write_vernier(log: ForceLog, path: str | Path) -> None:
    """Write a force log as `read_vernier` reads it."""
    rows = [f"{t:.6f},{f:.6g}" for t, f in zip(log.time, log.force, strict=True)]
    atomic_files.write_bytes(path, "\n".join(["Time (s),Force (N)", *rows, ""]).encode())


def read_vernier(path: str | Path) -> ForceLog:
    """Read the CSV export of Vernier's programs: its first column of time and of force.

    Raises BadInput where there is none of either, or a line is no numbers.
    """
    places: dict[str, tuple[int, str]] = {}
    rows: list[tuple[float, float]] = []
    for number, line in enumerate(lines(path, what="a dynamometer's CSV"), start=1):
        semicolons = ";" in line
        try:
            cells = next(csv.reader([line], delimiter=";" if semicolons else ","), [])
        except csv.Error as error:
            raise BadInput(f"{path}, line {number}: {error}") from None
        if not places:
            places = _places(path, cells) if line.strip() else {}
        elif line.strip():
            rows += _row(f"{path}, line {number}", cells, places, semicolons)
    if len(rows) < 2 * REST:
        raise BadInput(f"{path}: {len(rows)} samples of force; expected {2 * REST} or more")
    time, force = np.array(rows).T
    if not (np.diff(time) > 0.0).all():
        raise BadInput(f"{path}: its time does not rise; export one run alone")
    return ForceLog(time, force)


def _places(path: str | Path, header: list[str]) -> dict[str, tuple[int, str]]:
    """Place and unit of the columns of time and force, by a header such as "Run 1: Force (N)"."""
    found: dict[str, tuple[int, str]] = {}
    for k, cell in enumerate(header):
        if match := COLUMN.search(cell):
            found.setdefault(match[1].lower(), (k, match[2].strip()))
    wanted = found.get("time", (0, ""))[1] in TIMES and found.get("force", (0, ""))[1] == "N"
    if not wanted:
        raise BadInput(
            f'{path}, line 1: expected columns "Time (s)" and "Force (N)", as Vernier\'s programs '
            f"export them; found {', '.join(header)[:80]!r}"
        )
    return found


def _row(
    where: str, cells: list[str], places: dict[str, tuple[int, str]], comma: bool
) -> list[tuple[float, float]]:
    """Time [s] and force [N] of a line; nothing where the run has ended before others did."""
    texts = [cells[k].strip() if k < len(cells) else "" for k, _ in places.values()]
    if not all(texts):
        return []
    try:
        numbers = [float(text.replace(",", ".") if comma else text) for text in texts]
    except ValueError:
        raise BadInput(f"{where}: expected numbers, found {', '.join(texts)[:60]!r}") from None
    if not np.isfinite(numbers).all():
        raise BadInput(f"{where}: a number that is not finite")
    named = dict(zip(places, numbers, strict=True))
    return [(named["time"] * TIMES[places["time"][1]], named["force"])]


def touch_time(recording: Recording) -> float:
    """Time [s] in the recording at which its current shows the touch; BadInput without one."""
    windowing = Windowing()
    rows = windowing.features(windowing.samples(recording)[np.newaxis])[0]
    touched = np.flatnonzero(rows[:, SINCE] > 0.0)
    if not touched.size:
        raise BadInput("no contact shows in the current, so the dynamometer cannot be merged by it")
    k = int(touched[0])
    ends = windowing.times(round((recording.time[-1] - recording.time[0]) * windowing.sampling) + 1)
    return float(recording.time[0] + ends[k] - rows[k, SINCE])


def merged(recording: Recording, log: ForceLog) -> Recording:
    """Return the recording with the dynamometer's force [N] as its channel `force`, rest removed.

    Between the dynamometer's samples the force is on a straight line, beyond them it is the nearest
    one. Raises BadInput where either shows no contact, or the force begins or ends in a grasp.
    """
    onset, rest = log.onset()
    shift = touch_time(recording) - onset
    time, force = log.time + shift, log.force - rest
    for end, value, short in (
        ("begins", force[0], time[0] > recording.time[0]),
        ("ends", force[-1], time[-1] < recording.time[-1]),
    ):
        if short and abs(value) > TOUCHED:
            raise BadInput(f"the dynamometer's run {end} in the grasp; it must go on around it")
    said = table(recording.conversion)
    said["dynamometer"] = {
        "shift_s": shift, "rest_N": rest, "period_s": float(np.median(np.diff(log.time)))
    }  # fmt: skip
    made = recording.with_channels(
        {"force": np.interp(recording.time, time, force)}, {"force": "N"}
    )
    return replace(made, conversion=json.dumps(said, sort_keys=True))
