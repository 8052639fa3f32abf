"""Stepper: its bits beside those of `simulate`, and what a kilohertz of its ticks costs.

Each shipped experiment of one run and without effects to add, under the sampled controller: all
ticks of it, one a call, against the samples of `simulate` at the same tolerance. Share: processor
time of these calls over the time that they simulate, the least of some repeats.
"""

import time
from dataclasses import replace

import numpy as np

from benchmarks.harness import Row, main, must_show
from hannes import load_experiment, simulate, start
from hannes.core.errors import BadInput
from hannes.simulation.experiment import shipped
from hannes.simulation.experiment.variants import Variant

RTOL, REPEATS, QUICK = 1e-3, 25, 2
CHANNELS = ("reference", "position", "current", "duty", "force")
MOST = 0.05  # of a core


def variants() -> dict[str, Variant]:
    """The experiments, at 1 kHz under the sampled controller."""
    found = {}
    for name in shipped.names():
        try:
            first = load_experiment(name)[0]
        except BadInput:  # one that needs no simulation
            continue
        if not first.hand.effects:
            sampled = replace(first.experiment, controller="sampled", noise={})
            found[name] = replace(first, experiment=sampled)
    return found


def differing(variant: Variant) -> int:
    """Values of the channels that differ from those of `simulate` in a bit."""
    wanted = simulate(variant.hand, variant.experiment, rtol=RTOL).require()
    stepper = start(variant.hand, variant.experiment, rtol=RTOL)
    rows = [stepper.step() for _ in range(wanted.time.size - 1)]
    return sum(
        int(np.count_nonzero(np.array([row[name] for row in rows]) != wanted[name][:-1]))
        for name in CHANNELS
    )


def share(variant: Variant, repeats: int) -> float:
    """Processor time over simulated time, the least of the repeats."""
    took = []
    for _ in range(repeats):
        stepper = start(variant.hand, variant.experiment, rtol=RTOL)
        began = time.process_time()
        while stepper.time < variant.experiment.duration:
            stepper.step()
        took.append((time.process_time() - began) / stepper.time)
    return min(took)


def measure(quick: bool) -> tuple[list[Row], list[Row]]:
    """A row an experiment."""
    rows = [
        {"experiment": name, "differing": differing(each),
         "share": share(each, QUICK if quick else REPEATS)}
        for name, each in variants().items()
    ]  # fmt: skip
    differ, most = sum(row["differing"] for row in rows), max(row["share"] for row in rows)
    return rows, [
        must_show("values that differ from simulate's", differ, 0, differ == 0),
        must_show("share of a core at 1 kHz, most", most, MOST, most <= MOST),
    ]


if __name__ == "__main__":
    main(__doc__, "stepper", measure)
