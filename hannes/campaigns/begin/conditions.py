"""Runs that repeat one command, grouped: by the command itself, else by duration and name."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from hannes.core.recording.recording import Recording

ALIKE = 0.02  # of the command's range: RMS by which repeats may differ
AS_LONG = 0.05  # of the duration
GRID = 400  # points at which two commands are compared


@dataclass(frozen=True)
class Condition:
    """Runs under one command; `why` says by what they were grouped."""

    name: str
    files: tuple[Path, ...]
    why: str


def conditions(files: Sequence[Path], recordings: Sequence[Recording]) -> list[Condition]:
    """Group recordings (with their files) into conditions, in the order of their first run."""
    groups: list[list[int]] = []
    for k, recording in enumerate(recordings):
        for group in groups:
            if _alike(recordings[group[0]], recording, files[group[0]], files[k]):
                group.append(k)
                break
        else:
            groups.append([k])
    names = _names([files[group[0]] for group in groups])
    return [
        Condition(name, tuple(files[k] for k in group), _why(recordings[group[0]]))
        for name, group in zip(names, groups, strict=True)
    ]


def _alike(first: Recording, second: Recording, one: Path, other: Path) -> bool:
    length, span = (float(each.time[-1] - each.time[0]) for each in (first, second))
    if "reference" not in first or "reference" not in second:
        return abs(span - length) < AS_LONG * max(length, span) and _stem(one) == _stem(other)
    moments = np.linspace(0.0, min(length, span), GRID)
    commands = [np.interp(moments, r.time - r.time[0], r["reference"]) for r in (first, second)]
    extent = max(float(np.ptp(each)) for each in commands)
    apart = float(np.sqrt(np.mean((commands[0] - commands[1]) ** 2)))
    return apart <= ALIKE * max(extent, 1e-12) and abs(span - length) < 0.2 * max(length, span)


def _why(recording: Recording) -> str:
    return "the same command" if "reference" in recording else "equal length and name"


def _stem(file: Path) -> str:
    """A file's name without the numbers that count runs."""
    return re.sub(r"[-_ ]*\d+$", "", re.sub(r"-\d{3}$", "", file.name.split(".")[0]))


def _names(files: Sequence[Path]) -> list[str]:
    """Different names of conditions, from those of their first files."""
    found: list[str] = []
    for number, file in enumerate(files, start=1):
        name = _stem(file).replace("_", " ") or "command"
        found.append(name if name not in found else f"{name}, command {number}")
    return found
