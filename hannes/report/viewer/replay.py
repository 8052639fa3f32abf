"""From a recording to the simulation that draws it: a recording has no joint angles."""

from dataclasses import dataclass, replace

import numpy as np

from hannes.core.errors import BadInput
from hannes.core.recording import time_lag
from hannes.core.recording.recording import Recording
from hannes.plants.hand.channel_limits import EXPECTED
from hannes.plants.hand.plant import TOLERANCE, HandPlant
from hannes.plants.hand.recorded_experiment import experiment_of
from hannes.plants.hand.recorded_hand import hand_of
from hannes.simulation.experiment.experiment import Experiment
from hannes.simulation.experiment.reader import parse_experiment
from hannes.simulation.hand.hand import Hand
from hannes.simulation.simulate import simulate
from hannes.simulation.trajectory import Trajectory


@dataclass(frozen=True, eq=False)
class Replay:
    """A recording, the hand and the experiment that were simulated for it, and what came out.

    `start`: when the trajectory's time 0 s was, by the recording's clock [s]; `aligned`: it was
    found by comparing positions.
    """

    recording: Recording
    hand: Hand
    experiment: Experiment
    trajectory: Trajectory
    start: float
    aligned: bool = False

    @property
    def posed(self) -> Hand:
        """The hand with the values of the experiment, its object included."""
        return self.hand.with_values(self.experiment.overrides())

    def states(self, times: np.ndarray) -> np.ndarray:
        """States at times of the recording [s], shape (n, states), linear between samples."""
        return self._at(times, self.trajectory.states)

    def output(self, name: str, times: np.ndarray) -> np.ndarray:
        """An output at times of the recording [s], shape (n,) or (n, size)."""
        return self._at(times, self.trajectory[name])

    def _at(self, times: np.ndarray, table: np.ndarray) -> np.ndarray:
        since = times - self.start
        if np.array_equal(since, self.trajectory.time):
            return table
        columns = table.reshape(len(table), -1).T
        found = [np.interp(since, self.trajectory.time, column) for column in columns]
        return np.stack(found, axis=1).reshape(len(since), *table.shape[1:])

    def gap(self, name: str) -> float:
        """RMS of simulated minus recorded, in the channel's unit."""
        miss = self.output(name, self.recording.time) - self.recording[name]
        return float(np.sqrt(np.mean(miss**2)))


def replay(recording: Recording, hand: Hand | None = None) -> Replay:
    """Simulate what a recording was made of, with `hand` or else with the recording's own.

    Raises BadInput for a recording of another plant, one in other units, or one that has neither a
    reference nor an experiment; ComputationFailed where the simulation does not end.
    """
    _require_hand(recording)
    chosen = hand or hand_of(recording.hand)
    own = recording.source == "simulated" and bool(recording.experiment)
    if own:
        experiment = replace(parse_experiment(recording.experiment), noise={})
    else:
        HandPlant(chosen).check(recording)
        experiment = experiment_of(recording)
    ran = simulate(chosen, experiment, rtol=TOLERANCE).require()
    start, aligned = (_clock(recording, ran), False) if own else _start(recording, ran)
    return Replay(recording, chosen, experiment, ran, start, aligned)


def _require_hand(recording: Recording) -> None:
    """Raise BadInput where a channel cannot be one of the hand's: unit, or an impossible angle."""
    if recording.plant not in ("", "hand"):
        raise BadInput(
            f'the recording is of the plant "{recording.plant}": only the hand can be drawn'
        )
    known = HandPlant.channels
    for name in recording.names:
        if name in known and recording.units[name] != known[name]:
            raise BadInput(
                f'channel "{name}" comes in {recording.units[name]}, expected {known[name]}, of '
                "the output shaft of the hand's motor: only recordings of the hand can be drawn"
                if known[name] == "rad"
                else f'channel "{name}" comes in {recording.units[name]}, expected {known[name]}'
            )
    for name in ("reference", "position"):
        peak = float(np.abs(recording[name]).max()) if name in recording else 0.0
        most = EXPECTED[name].peak[1]
        if peak > most:
            raise BadInput(
                f'channel "{name}" reaches {peak:.3g} rad, at most {most:g} rad are expected at '
                "the output shaft: `hannes check` says which unit was taken for which"
            )


def _start(recording: Recording, ran: Trajectory) -> tuple[float, bool]:
    """When the simulation began by the recording's clock [s], and whether positions say so."""
    first = float(recording.time[0])
    if "reference" in recording:
        return first, False
    if "position" in recording:
        try:
            lag = time_lag.best_lag(
                recording.time - first, recording["position"], ran.time, ran["position"]
            )
        except BadInput:  # one of the two stands still
            return first, False
        return first + lag.value, True
    return _clock(recording, ran), False


def _clock(recording: Recording, ran: Trajectory) -> float:
    """Time 0 of the recording's clock, or its first sample where that lies beyond the run."""
    first = float(recording.time[0])
    return 0.0 if 0.0 <= first < ran.time[-1] else first


def without_effects(shown: Replay) -> Replay | None:
    """The same with every effect at `off`; None where the hand has none that is on.

    A law by which the object moves is part of the experiment and stays.
    """
    off = {
        effect.full_name(each.name): each.off
        for effect in shown.hand.present_effects()
        if not any(name.startswith("object_angle") for t in effect.terms for name in t.writes)
        for each in effect.amplitudes
        if each.off is not None
    }
    if not off:
        return None
    hand = shown.hand.with_values(off)
    ran = simulate(hand, shown.experiment, rtol=TOLERANCE).require()
    return replace(shown, hand=hand, trajectory=ran)
