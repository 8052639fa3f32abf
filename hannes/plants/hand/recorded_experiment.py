"""The experiment under which a recording of a hand was made, with its recorded reference."""

from dataclasses import replace
from functools import lru_cache

import numpy as np

from hannes.core.errors import BadInput
from hannes.core.io.toml_table import Table, parsed
from hannes.core.recording.recording import Recording
from hannes.simulation.catalogue import laws_of_objects
from hannes.simulation.experiment.experiment import Experiment, Reference

MOST_KNOTS = 40  # a reference with more corners is integrated without restarts


def experiment_of(recording: Recording) -> Experiment:
    """The experiment of a recording: object, values, controller, and the recorded reference.

    The reference is in rad at the output shaft. Raises BadInput where the recording has neither a
    reference nor an experiment.
    """
    planned = _planned(recording)
    if "reference" not in recording:
        if planned is None:
            raise BadInput(
                "the recording has neither a channel reference_rad nor an experiment: "
                "the command of the hand is unknown"
            )
        return replace(planned, noise={})
    since = recording.time - recording.time[0]
    duration = float(since[-1])
    sampling = max(1, round(duration / float(np.median(np.diff(since))))) / duration
    reference = recorded_reference(since, recording["reference"])
    if planned is None:
        return Experiment("recorded", duration, reference, sampling=sampling)
    return replace(planned, duration=duration, reference=reference, sampling=sampling, noise={})


def with_sampled_controller(recording: Recording) -> Recording | None:
    """The same with a sampled controller in its experiment; None where it has one already.

    One without an experiment gets that of a free run under its own recorded reference.
    """
    import tomli_w

    planned = _planned(recording)
    if planned is not None and planned.controller == "sampled":
        return None
    if planned is None and "reference" not in recording:
        return None
    content = parsed(recording.experiment) if planned is not None else _unplanned(recording)
    return replace(recording, experiment=tomli_w.dumps({**content, "controller": "sampled"}))


def _unplanned(recording: Recording) -> dict[str, object]:
    """What an experiment must say; duration, sampling and reference are those recorded."""
    duration = f"{float(np.ptp(recording.time))!r} s"
    points = [["0 s", "0 rad"], [duration, "0 rad"]]
    reference = {"kind": "ramp", "points": points}
    return {"title": "recorded", "duration": duration, "sampling": "1 kHz", "reference": reference}


def _planned(recording: Recording) -> Experiment | None:
    if not recording.experiment:
        return None
    return _parsed(recording.experiment)


@lru_cache(maxsize=64)  # a fit asks for the same few experiments hundreds of times
def _parsed(text: str) -> Experiment:
    from hannes.simulation.experiment.reader import parse_experiment

    return parse_experiment(text)


def motion(recording: Recording) -> np.ndarray:
    """The motion by which phases are separated: reference, else position [rad], shape (n,)."""
    for name in ("reference", "position"):
        if name in recording:
            return recording[name]
    return np.interp(recording.time, *experiment_of(recording).reference.knots)


def effects_on_object(text: str) -> list[str]:
    """Names of the effects in an experiment's TOML by which its object moves."""
    if not text:
        return []
    from hannes.simulation.experiment.reader import KEYS

    named = Table.parse(text, "experiment", KEYS).texts("effects")
    return [name for name in named if name in laws_of_objects()]


def recorded_reference(times: np.ndarray, values: np.ndarray) -> Reference:
    """A sampled reference by its corners where it is piecewise linear, else by every sample."""
    slope = np.diff(values) / np.diff(times)
    kink = np.abs(np.diff(slope)) > 1e-4 * max(np.abs(slope).max(), 1e-12)
    corners = np.concatenate(([0], 1 + np.flatnonzero(kink), [times.size - 1]))
    if corners.size > MOST_KNOTS:
        return Reference(np.array([times, values]), kinked=False)
    return Reference(np.array([times[corners], values[corners]]))
