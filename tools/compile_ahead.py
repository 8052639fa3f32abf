"""Compiles models before they are asked for: `python -m tools.compile_ahead NAME ...`.

NAME: `hand`, the hand alone; `catalogue`, with all effects that a diagnosis tries; `floating`, with
an object that moves; `large`, with the effects of the data set of that name. A command that needs
one meanwhile waits for it.
"""

import sys
from collections.abc import Callable, Sequence

from hannes import Hand, effects, load_experiment, simulate, simulate_many
from hannes.dataset.spec import load_spec
from hannes.identification.diagnosis.generic_disturbances import EFFECTS as GENERIC
from hannes.plants.hand.plant import HandPlant


def catalogue() -> Hand:
    """The hand with all effects that a diagnosis of it tries."""
    plant = HandPlant()
    tried = (each for each in (*effects().values(), *GENERIC) if not plant.accepts(each))
    return plant.with_effects(*tried).hand


def many(hand: Hand) -> None:
    """One grasp as `simulate_many` runs it."""
    experiment = load_experiment("void-closure")[0].experiment
    asked = {"effects": hand.effects, "channels": ("current",), "progress": False}
    for grasp in simulate_many(hand, experiment, {"motor.resistance": [3.0]}, **asked):
        grasp.require()


def one(name: str) -> None:
    """A shipped experiment as `simulate` runs it."""
    variant = load_experiment(name)[0]
    simulate(variant.hand, variant.experiment).require()["force"]


MODELS: dict[str, Callable[[], None]] = {
    "hand": lambda: many(Hand()),
    "catalogue": lambda: many(catalogue()),
    "floating": lambda: one("floating-cylinder"),
    "large": lambda: many(load_spec("large").hand),
}


def main(names: Sequence[str]) -> None:
    """Compile each."""
    for name in names:
        MODELS[name]()


if __name__ == "__main__":
    main(sys.argv[1:])
