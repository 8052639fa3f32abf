"""Candidate experiments for a hand: the recorded ones slower, smaller, or with another object."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from hannes.core.recording.recording import Recording
from hannes.simulation.experiment.reader import experiment_text

# Name of what is changed -> share of the speed, share of the amplitude.
CHANGES = {
    "half speed": (0.5, 1.0),
    "0.25 speed": (0.25, 1.0),
    "0.15 speed": (0.15, 1.0),
    "0.85 amplitude": (1.0, 0.85),
}
BALL = "soft ball"
RATE = 1000.0  # Hz, of what would be recorded
MEASURED = ("force", "sensor")  # by the object, which the ball does not


def proposals(recorded: Mapping[str, Recording], things: Mapping[str, str]) -> dict[str, Recording]:
    """Name of a run -> a recording of it with times and a reference; its channels are zero.

    `recorded`: condition -> a recording of it; `things`: condition -> its object, as text.
    """
    found = {}
    for name, recording in _plain(recorded, things).items():
        if "reference" in recording:
            for change, shares in CHANGES.items():
                found[f"{name}, {change}"] = _changed(recording, *shares)
            found.setdefault(BALL, _other(recording, experiment_text(BALL.replace(" ", "-"))))
    return {name: each for name, each in found.items() if name not in recorded}


def _plain(recorded: Mapping[str, Recording], things: Mapping[str, str]) -> dict[str, Recording]:
    """The shortest recording of each object.

    Named by its condition up to the comma, or by the whole of it where two objects would share it.
    """
    shortest: dict[str, str] = {}  # thing -> condition
    for condition in sorted(recorded, key=lambda name: float(np.ptp(recorded[name].time))):
        shortest.setdefault(things[condition], condition)
    chosen = [name for name in recorded if name in shortest.values()]
    short = [name.partition(",")[0] for name in chosen]
    return {
        brief if short.count(brief) == 1 else name: recorded[name]
        for name, brief in zip(chosen, short, strict=True)
    }


def _changed(recording: Recording, speed: float, amplitude: float) -> Recording:
    since = recording.time - recording.time[0]
    factor = amplitude / speed
    time = np.arange(round(since[-1] * factor * RATE) + 1) / RATE
    reference = amplitude * np.interp(time / factor, since, recording["reference"])
    return _blank(recording, time, reference, recording.experiment)


def _other(recording: Recording, experiment: str) -> Recording:
    since = recording.time - recording.time[0]
    run = _blank(recording, since, recording["reference"], experiment)
    channels = {name: each for name, each in run.channels.items() if name not in MEASURED}
    return replace(run, channels=channels, units={name: run.units[name] for name in channels})


def _blank(
    recording: Recording, time: np.ndarray, reference: np.ndarray, experiment: str
) -> Recording:
    channels = {name: np.zeros(time.size) for name in recording.names}
    channels |= {"time": time, "reference": reference}
    return Recording(channels, recording.units, plant="hand", experiment=experiment)
