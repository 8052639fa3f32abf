"""From a recording to the simulation that draws it: a recording has no joint angles."""

from dataclasses import dataclass, replace

import numpy as np

from hannes.core.errors import BadInput
from hannes.core.recording.recording import Recording
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

    `trajectory` starts at time 0 s, the recording at `start` [s].
    """

    recording: Recording
    hand: Hand
    experiment: Experiment
    trajectory: Trajectory
    start: float

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

    Raises BadInput for a recording of another plant, or one that has neither a reference nor
    an experiment; ComputationFailed where the simulation does not end.
    """
    if recording.plant not in ("", "hand"):
        raise BadInput(
            f'the recording is of the plant "{recording.plant}": only the hand can be drawn'
        )
    chosen = hand or hand_of(recording.hand)
    experiment, start = _experiment(recording, chosen)
    ran = simulate(chosen, experiment, rtol=TOLERANCE).require()
    return Replay(recording, chosen, experiment, ran, start)


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


def _experiment(recording: Recording, hand: Hand) -> tuple[Experiment, float]:
    """What to simulate, and when it began by the recording's clock [s]."""
    if recording.source == "simulated" and recording.experiment:
        return replace(parse_experiment(recording.experiment), noise={}), 0.0
    HandPlant(hand).check(recording)
    start = float(recording.time[0]) if "reference" in recording else 0.0
    return experiment_of(recording), start
