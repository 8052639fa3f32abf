"""Aligns two clocks of a recording: reference and measurement, or experiment and log.

A machine lags its reference even when every clock is right. Measured motion is therefore compared
with *simulated* motion under the same command, unless the mapping says by = "command" and gives
the machine's own lag.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hannes.campaigns.foreign.mapping import AlignRule, ColumnMap
from hannes.core.errors import BadInput
from hannes.core.recording.recording import Recording
from hannes.core.recording.time_lag import Lag, lag_behind
from hannes.plants.protocol import Plant

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Shift:
    """How a clock was shifted: `value` [s] is the delay of the measurement; see `what`."""

    rule: AlignRule
    lag: Lag
    value: float
    what: str

    def as_dict(self) -> dict[str, Any]:
        """Plain data, with a 95 % interval."""
        reach = 1.96 * self.lag.deviation
        return {
            "value": self.value,
            "low": self.value - reach,
            "high": self.value + reach,
            "unit": "s",
            "what": self.what,
            "channel": self.rule.channel,
            "by": self.rule.by,
            "machine_lag": self.rule.lag if self.rule.by == "command" else None,
            "correlation": self.lag.correlation,
        }


def aligned(recording: Recording, mapping: ColumnMap) -> tuple[Recording, Shift | None]:
    """Return the recording with its clock moved as the mapping asks, and by how much."""
    rule = mapping.align
    if rule is None:
        return recording, None
    if rule.to == "experiment":
        return _onto_experiment(recording, rule, mapping.plant)
    return _onto_reference(recording, rule, mapping.plant)


def _onto_reference(recording: Recording, rule: AlignRule, plant: Plant) -> tuple[Recording, Shift]:
    """Move the recorded reference in time until the measured motion follows it."""
    time, reference = recording.time, recording["reference"]
    followed = reference
    if rule.by == "simulation":
        followed = plant.simulate({}, recording)[rule.channel]
    lag = _lag(recording, rule, time, followed)
    value = lag.value - rule.lag
    what = "shift of the reference, later where positive; times without it were dropped"
    kept = (time - value >= time[0]) & (time - value <= time[-1])
    if np.count_nonzero(kept) < 2:
        raise BadInput("align: nothing is left once the reference is moved")
    moved = np.interp(time - value, time, reference)
    cut = {name: values[kept] for name, values in recording.channels.items()}
    return replace(recording, channels={**cut, "reference": moved[kept]}), Shift(
        rule, lag, value, what
    )


def _onto_experiment(
    recording: Recording, rule: AlignRule, plant: Plant
) -> tuple[Recording, Shift]:
    """Move the recording's clock until its motion is that of the experiment."""
    times, followed = _experiment_motion(recording, rule, plant)
    rough = recording.time[0] - times[0]  # a foreign clock may count from anywhere
    early = replace(recording, channels={**recording.channels, "time": recording.time - rough})
    lag = _lag(early, rule, times, followed)
    value = lag.value - rule.lag + rough
    what = "subtracted from every time: zero is the start of the experiment"
    channels = {**recording.channels, "time": recording.time - value}
    return replace(recording, channels=channels), Shift(rule, lag, value, what)


def _experiment_motion(
    recording: Recording, rule: AlignRule, plant: Plant
) -> tuple[FloatArray, FloatArray]:
    """Times of the experiment [s], and what the channel follows there."""
    from hannes.simulation.experiment.reader import parse_experiment

    if plant.name != "hand":
        raise BadInput('align.to = "experiment": experiments are the hand\'s; align to "reference"')
    experiment = parse_experiment(recording.experiment)
    times = experiment.times
    if rule.by == "command":
        return times, np.interp(times, *experiment.reference.knots)
    blank = Recording(
        {"time": times, rule.channel: np.zeros(times.size)},
        {"time": "s", rule.channel: recording.units[rule.channel]},
        experiment=recording.experiment,
    )
    return times, plant.simulate({}, blank)[rule.channel]


def _lag(recording: Recording, rule: AlignRule, times: FloatArray, followed: FloatArray) -> Lag:
    try:
        return lag_behind(recording.time, recording[rule.channel], times, followed, rule.within)
    except BadInput as error:
        raise BadInput(f"align: {error}") from None
