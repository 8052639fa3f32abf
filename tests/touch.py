"""Contact geometry of the compiled hand by its own stages, and poses to ask it at."""

import functools

import numpy as np
from runs import Bench, channels

from hannes.core.kernels.jit import kernel


@functools.cache
def touching(compiled):
    """The stages that touch consists of, as one function."""
    kinematics, contact = compiled.observed.kinematics, compiled.observed.contact
    outputs = np.zeros(compiled.outputs.size)

    @kernel
    def of_pose(y, p, c):
        kinematics(y, p, c)
        contact(0.0, y, y, p, c, outputs.copy())

    return of_pose


class Touch:
    """Contact geometry of the compiled hand's own stages."""

    def __init__(self, shape, values):
        self.bench = Bench(values, shape)
        self.touch = touching(self.bench.compiled)

    def __call__(self, angles, speeds=None):
        state = self.bench.rest.copy()
        state[self.bench.place("joint_angle")] = angles
        state[self.bench.place("joint_speed")] = np.zeros(10) if speeds is None else speeds
        c, layout = channels()
        self.touch(state, self.bench.p, c)
        return lambda name: c[layout[name]]


def poses():
    low, high = np.tile([0.0, 0.0], 5), np.tile([1.1, 1.2], 5)
    return np.random.default_rng(2).uniform(low, high, (20, 10))


def moving():
    """Poses with a speed for every joint."""
    rng = np.random.default_rng(3)
    return [(angles, rng.uniform(-5, 5, 10)) for angles in poses()]
