"""One model for all tests: the whole catalogue and an effect that breaks; and its runs.

All amplitudes are at off but those given. To compile it takes most of a minute, and each other set
of effects a third of that: tests that need any effect use this one.
"""

import functools
from dataclasses import replace

from runs import BREAK, grasp, reference

from benchmarks.truth.effects import SIZES
from hannes.simulation.catalogue import effects
from hannes.simulation.energy_balance import energy_ledger
from hannes.simulation.hand.hand import Hand
from hannes.simulation.simulate import simulate

CATALOGUE = effects()
EVERYTHING = Hand((*CATALOGUE, BREAK))
AMPLITUDES = {
    effect.full_name(each.name): each for effect in CATALOGUE.values() for each in effect.amplitudes
}
BALL = {"stiffness": 800.0, "damping": 20.0, "radius": 0.036, "x": 4e-3, "y": -47e-3}
EXPERIMENTS = {
    "void": grasp(None),
    "dynamometer": grasp(),
    "soft ball": grasp("sphere", **BALL),
    "held ball": replace(
        grasp("sphere", 1.5, **BALL), reference=reference(((0.0, 0.0), (0.637, 9.84)))
    ),
    "finely": grasp(None, 0.3, sampling=20_000.0),
    "sampled": grasp(controller="sampled"),
}


# Of the second formulation: parameters of the catalogue with their physical ranges.
RANGES = {name: size for name, size in SIZES.items() if name.partition(".")[0] in CATALOGUE}


@functools.cache
def ran(experiment, **values):
    """A cached run; values by full name with __ for the dot."""
    hand = EVERYTHING.with_values({n.replace("__", "."): x for n, x in values.items()})
    found = simulate(hand, EXPERIMENTS[experiment], rtol=1e-6, effects=EVERYTHING.effects)
    return found.require()


@functools.cache
def ledger(name=""):
    """Energies of a grasp, the amplitude `name` at half its largest physical size."""
    hand = EVERYTHING.with_values({name: 0.5 * RANGES[name].high} if name else {})
    run = simulate(hand, grasp(sampling=20_000.0), rtol=1e-6, effects=EVERYTHING.effects)
    return energy_ledger(run.require())


def broken(how, since=0.05):
    """A hand whose rates break."""
    return EVERYTHING.with_values({"breaking.way": how, "breaking.since": since})
