"""A campaign of the axis, simulated here, that rubs harder one way."""

import functools

import numpy as np

from hannes.core.recording.recording import Recording
from hannes.plants.axis.plant import Axis
from hannes.simulation.catalogue import effect

UNITS = {"time": "s", "reference": "m", "position": "m", "drive": "V"}


@functools.cache
def run(viscous, seed):
    """10 s of swings, the axis rubbing harder one way by the share `viscous`; noise of 10 mV."""
    t = np.arange(10_001) / 1000.0
    reference = 0.05 * (1.0 - np.cos(0.8 * np.pi * t)) * (1.0 + 0.3 * np.sin(0.37 * t + seed))
    bare = Recording({"time": t, "reference": reference, "position": reference}, {
        name: UNITS[name] for name in ("time", "reference", "position")
    })  # fmt: skip
    axis = Axis().with_effects(effect("direction_friction"))
    found = axis.simulate({"direction_friction.viscous": viscous, "axis.mass": 96.0}, bare)
    drive = found["drive"] + 0.01 * np.random.default_rng(seed).standard_normal(t.size)
    channels = {"time": t, "reference": reference, "position": found["position"], "drive": drive}
    return Recording(channels, UNITS, plant="axis")


def campaign(folder, roles, viscous=0.2):
    """Path of a campaign with one recording of each role."""
    rows = []
    for seed, role in enumerate(roles):
        run(viscous, seed).write(folder / f"{seed}.h5")
        rows.append(f'[[recording]]\nfile = "{seed}.h5"\nrole = "{role}"\n')
    (folder / "campaign.toml").write_text('plant = "axis"\n' + "".join(rows), encoding="utf-8")
    return folder / "campaign.toml"
