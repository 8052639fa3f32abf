"""What the residual of a recording of a hand may go with: angle, speed, load, contact."""

import numpy as np

from hannes.core.recording.recording import Recording
from hannes.plants.hand.recorded_experiment import experiment_of, motion

TOUCHING = 0.02  # of the largest force, above which something is touched
LEAST = 1.0  # N, likewise, as for the figures of a grasp: a sensor is noisy where nothing is


def quantities(recording: Recording) -> dict[str, np.ndarray]:
    """angle [rad], speed [rad/s], load [N] and contact (0 or 1), shape (n,) each.

    The load is what a force sensor logs. Without one it is unknown where there is an object.
    """
    angle = recording["position"] if "position" in recording else motion(recording)
    found = {"angle": angle, "speed": np.gradient(angle, recording.time)}
    for name in ("force", "sensor"):
        if name in recording:
            load = np.abs(recording[name])
            touched = (load > max(TOUCHING * float(load.max()), LEAST)).astype(float)
            return {**found, "load": load, "contact": touched}
    if experiment_of(recording).object is None:
        nothing = np.zeros(len(recording))
        return {**found, "load": nothing, "contact": nothing}
    return found
