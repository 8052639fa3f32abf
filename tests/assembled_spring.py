"""A mass on a spring as a compiled model, with effects of a test."""

from hannes.core.effect import Effect
from hannes.core.layout import Layout, Slot
from hannes.simulation.compiler.assemble import Compiled, Equations, assemble
from tests import mass_on_spring


def _layout(*names: str) -> Layout:
    return Layout(tuple(Slot(name, "1", "of the test") for name in names))


def spring(*effects: Effect) -> Compiled:
    """The model, assembled anew where these effects are new."""
    slots = ("stiffness", "level"), ("place", "speed"), ("push",), ("force",)
    return assemble(
        Equations(mass_on_spring, *(_layout(*each) for each in slots), memory=1), effects
    )
