"""A machine of a few lines for tests of calibration: an oven that warms to a known law.

heat [m] = power x gain x resistance x (1 - exp(-t / time)) + offset; glow [1] = 1 - exp(-t / time)
Gain and resistance show only through their product; `paint` shows nowhere.
"""

from dataclasses import replace
from typing import ClassVar

import numpy as np

from hannes.campaigns.campaign import Campaign, Entry
from hannes.core.errors import ComputationFailed
from hannes.core.io.toml_table import Table
from hannes.core.parameter import Parameter
from hannes.core.recording.recording import Recording
from hannes.plants.plain import PlainPlant

UNITS = {"time": "s", "power": "V", "heat": "m", "glow": "1"}
TIMES = np.arange(0.0, 2.0, 0.01)


class Oven(PlainPlant):
    """Plant: the oven; `heat` is in m, a unit that the table of units knows."""

    name = "oven"
    channels = UNITS
    required = ("power",)
    judged = ("heat", "glow")
    base = (
        Parameter("oven.gain", 2.0, "1", (0.1, 10.0), "of the heater"),
        Parameter("oven.resistance", 3.0, "ohm", (0.1, 10.0), "of the heater"),
        Parameter("oven.time", 0.5, "s", (0.05, 5.0), "to warm up"),
        Parameter("oven.offset", 0.0, "m", (-5.0, 5.0), "of the sensor"),
        Parameter("oven.paint", 1.0, "1", (0.0, 2.0), "its colour"),
        Parameter("oven.hidden", 0.0, "1", (-1.0, 1.0), "cools more, the hotter it is"),
    )
    free: ClassVar = {"oven.gain": 0.2, "oven.time": 0.1, "oven.offset": 0.5}
    block = 0.2

    def simulate(self, parameters, recording):
        """Closed form; breaks down where it would warm up in less than 0.1 s."""
        p = self.parameters.with_values(parameters)
        if p["oven.time"] < 0.1:
            raise ComputationFailed("it bursts into flames")
        rise = 1.0 - np.exp(-recording.time / p["oven.time"])
        heat = recording["power"] * p["oven.gain"] * p["oven.resistance"] * rise
        return {"heat": heat * (1.0 - p["oven.hidden"] * rise) + p["oven.offset"], "glow": rise}


class RunToRun(Oven):
    """An oven that says by how much its runs differ."""

    run_to_run: ClassVar = {"oven.gain": 0.02, "oven.time": 0.005}
    start_time = 0.0


def run(rng, values, power=1.0, scatter=0.01, noise=0.01):
    """A recording whose gain and time differ from `values` by `scatter` (relative)."""
    empty = Recording(
        {"time": TIMES, "power": np.full(TIMES.size, power)}, dict(list(UNITS.items())[:2])
    )
    p = Oven().with_values(values).parameters
    drawn = {
        name: p[name] * (1.0 + share * scatter * rng.standard_normal())
        for name, share in (("oven.gain", 1.0), ("oven.time", 0.5))
    }
    found = Oven().simulate({**values, **drawn}, empty)
    seen = {name: x + noise * rng.standard_normal(x.size) for name, x in found.items()}
    return empty.with_channels(seen, {name: UNITS[name] for name in seen})


def campaign(seed, values, runs=8, plant=RunToRun, powers=(1.0, 2.0), shown=0, **asked):
    """A campaign of `runs` recordings in turn under `powers`; `asked` is its [calibrate]."""
    rng = np.random.default_rng(seed)
    how = {name: asked.pop(name) for name in ("scatter", "noise") if name in asked}
    entries = [
        Entry(
            f"run {k}",
            run(rng, values, powers[k % len(powers)], **how),
            f"power {k % len(powers)}",
            "fit",
        )
        for k in range(runs)
    ]
    entries = [replace(e, role="show") if k >= runs - shown else e for k, e in enumerate(entries)]
    return Campaign(
        plant(), plant(), tuple(entries), None, {}, "oven", calibrate=Table(asked, "oven.toml", ())
    )
