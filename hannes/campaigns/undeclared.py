"""Channels that a recording has and its plant has not: left out, unless the name is misspelt."""

import difflib
from collections.abc import Iterable
from dataclasses import replace

from hannes.core.recording.recording import Recording
from hannes.plants.protocol import Plant

NEAR = 0.6  # likeness of names from which one is taken for another, misspelt


def undeclared(recording: Recording, plant: Plant) -> tuple[str, ...]:
    """Names of channels that the plant does not have, nor one of nearly that name."""
    known = list(plant.channels)
    return tuple(
        name
        for name in recording.names
        if name not in known and not difflib.get_close_matches(name, known, cutoff=NEAR)
    )


def without(recording: Recording, names: Iterable[str]) -> Recording:
    """Return the recording with only its other channels."""
    if not (left_out := set(names)):
        return recording
    kept = {name: each for name, each in recording.channels.items() if name not in left_out}
    units = {name: each for name, each in recording.units.items() if name not in left_out}
    return replace(recording, channels=kept, units=units)


def said(names: Iterable[str], plant: Plant) -> str:
    """A line that names them, or an empty string."""
    listed = ", ".join(sorted(set(names)))
    return f"left out, for the plant {plant.name} has no such channel: {listed}" if listed else ""
