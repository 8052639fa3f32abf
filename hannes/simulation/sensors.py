"""From a simulation to a Recording: the hand's channels, with seeded sensor noise."""

import numpy as np

from hannes.core.recording.recording import Recording
from hannes.simulation.experiment.experiment import Experiment
from hannes.simulation.experiment.writer import experiment_toml
from hannes.simulation.hand.hand import Hand
from hannes.simulation.hand.hand_file import hand_toml
from hannes.simulation.hand.variables import OUTPUTS
from hannes.simulation.trajectory import Grasp, Trajectory

CHANNELS = ("reference", "position", "current", "duty", "supply", "force", "sensor")
UNITS = {"time": "s", **{slot.name: slot.unit for slot in OUTPUTS if slot.name in CHANNELS}}


def observe(hand: Hand, trajectory: Trajectory) -> Recording:
    """Return what the bench would have logged; `hand` is the one that was simulated.

    Noise is white and depends on the experiment's seed and the channel alone. `sensor` is there
    only where the object carries one. Raises ComputationFailed where the simulation did not end.
    """
    return logged(hand, trajectory.require().experiment, trajectory)


def logged(hand: Hand, experiment: Experiment, ran: Trajectory | Grasp) -> Recording:
    """The same of a grasp of a batch, which must have all of `CHANNELS`."""
    channels = {"time": ran.time}
    for name in CHANNELS:
        if name == "sensor" and not (experiment.object and experiment.object.sensor):
            continue
        channels[name] = noisy(experiment, name, ran[name])
    return Recording(
        channels,
        {name: UNITS[name] for name in channels},
        plant="hand",
        experiment=experiment_toml(hand, experiment),
        hand=hand_toml(hand),
        seed=experiment.seed if experiment.noise else None,
        source="simulated",
    )


def noisy(experiment: Experiment, name: str, values: np.ndarray) -> np.ndarray:
    """Add the white noise of one channel; `values` themselves where it has none."""
    spread = experiment.noise.get(name)
    if not spread:
        return values
    generator = np.random.default_rng([experiment.seed, CHANNELS.index(name)])
    return values + spread * generator.standard_normal(values.size)
