"""Stepper: its bits beside those of `simulate`, and what a kilohertz of its ticks costs.

The first run of each shipped experiment, under the sampled controller: all ticks of it, one a call,
against the samples of `simulate` at the same tolerance. Share: processor time of these calls over
the time that they simulate, least and median of some repeats; the bound is on the median.
"""

import time
from dataclasses import replace

import numpy as np

from benchmarks.harness import Row, interval, main, must_show
from hannes import simulate, start
from hannes.simulation.experiment import shipped
from hannes.simulation.experiment.friction_curve import FrictionCurve
from hannes.simulation.experiment.load import load
from hannes.simulation.experiment.variants import Variant

RTOL, REPEATS, QUICK = 1e-3, 25, 2
CHANNELS = ("reference", "position", "current", "duty", "force")
MOST = 0.05  # of a core


def variants() -> dict[str, Variant]:
    """The experiments, at 1 kHz under the sampled controller."""
    found = {}
    for name in shipped.names():
        asked = load(name)
        if not isinstance(asked, FrictionCurve):  # which needs no simulation
            sampled = replace(asked[0].experiment, controller="sampled", noise={})
            found[name] = replace(asked[0], experiment=sampled)
    return found


def differing(variant: Variant) -> int:
    """Values of the channels that differ from those of `simulate` in a bit."""
    wanted = simulate(variant.hand, variant.experiment, rtol=RTOL).require()
    stepper = start(variant.hand, variant.experiment, rtol=RTOL)
    rows = [stepper.step() for _ in range(wanted.time.size - 1)]
    return sum(
        unlike(np.array([row[name] for row in rows]), wanted[name][:-1]) for name in CHANNELS
    )


def unlike(some: np.ndarray, others: np.ndarray) -> int:
    """Values (n,) that differ in a bit: 0 and -0 do, a NaN and its copy do not."""
    bits = (np.ascontiguousarray(each, dtype=float).view(np.int64) for each in (some, others))
    return int(np.count_nonzero(np.not_equal(*bits)))


def shares(variant: Variant, repeats: int) -> list[float]:
    """Processor time over simulated time, of each repeat."""
    took = []
    for _ in range(repeats):
        stepper = start(variant.hand, variant.experiment, rtol=RTOL)
        began = time.process_time()
        while stepper.time < variant.experiment.duration:
            stepper.step()
        took.append((time.process_time() - began) / stepper.time)
    return took


def measure(quick: bool) -> tuple[list[Row], list[Row]]:
    """A row an experiment."""
    rows: list[Row] = []
    for name, each in variants().items():
        took = shares(each, QUICK if quick else REPEATS)
        found = {"least": min(took), "share": float(np.median(took)), **interval(took)}
        effects = ", ".join(effect.name for effect in each.hand.effects)
        rows.append({"experiment": name, "differing": differing(each), **found, "adds": effects})
    differ = sum(row["differing"] for row in rows)
    most = max(row["share"] for row in rows if not row["adds"])
    return rows, [
        must_show("values that differ from simulate's", differ, 0, differ == 0),
        must_show("median share of a core at 1 kHz, hand alone, most", most, MOST, most <= MOST),
    ]


if __name__ == "__main__":
    main(__doc__, "stepper", measure)
