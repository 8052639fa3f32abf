"""What `hannes effects` prints: all effects, or one with what it is easily confused with."""

import textwrap
from collections.abc import Mapping
from pathlib import Path

from hannes.core.effect import Effect
from hannes.core.errors import BadInput, nearest
from hannes.core.ranged import own_ranges, ranged
from hannes.identification import confusability
from hannes.plants.protocol import Plant, find_plant
from hannes.simulation import catalogue
from hannes.simulation.compiler.assemble import Equations
from hannes.simulation.compiler.kernel_check import check_kernels
from hannes.simulation.hand.hand_file import own_catalogue

HAND = "hand"


def listed(plant: str | None) -> str:
    """All effects that ship, or those that a plant alone has."""
    return "\n".join(_in_short(each) for each in _known(plant).values())


def described(name: str, plant: str | None) -> str:
    """One effect: by name, or the user's own, refused where a run of the plant would refuse it.

    Of a plant that is named with that machine's own bounds.
    """
    if plant is None and (shipped := catalogue.effects().get(name)):
        return f"{shipped}\n{confusability.text(name)}"
    machine = find_plant(plant or HAND, Path.cwd())  # a diagnosis of the hand names those of it too
    found = own_catalogue(machine).get(name) or catalogue.effect(name)
    if ".py:" in name:
        _check(found, machine)
    return str(ranged(found, own_ranges(machine)))


def _known(plant: str | None) -> Mapping[str, Effect]:
    return catalogue.effects() if plant is None else own_catalogue(find_plant(plant, Path.cwd()))


def _check(effect: Effect, plant: Plant) -> None:
    """Raise BadInput in one line for what a run would refuse."""
    if effect.name in {**catalogue.effects(), **own_catalogue(plant)}:
        raise BadInput(f"effect {effect.name}: one that ships has this name: choose another")
    equations: Equations | None = getattr(plant, "compiled_from", None)
    if why := plant.accepts(effect):
        meant = _meant(equations, effect) if equations is not None else ""
        other = "" if plant.name != HAND else "; if it is for another plant, name that with --plant"
        what = f'effect {effect.name} does not fit the plant "{plant.name}": {why}'
        raise BadInput(what + meant + other)
    if equations is not None:
        check_kernels(equations, effect)


def _meant(equations: Equations, effect: Effect) -> str:
    """A did-you-mean clause for the first name that the plant does not know, or an empty string."""
    channels = [slot.name for slot in equations.channels.slots if equations.stage_of(slot.name)]
    layouts = (equations.parameters, equations.states, equations.channels)
    readable = ["t", *(slot.name for layout in layouts for slot in layout.slots)]
    own = [p.name for p in effect.parameters] + [s.name for s in effect.states]
    for term in effect.terms:
        for name in term.writes:
            if name not in channels:
                return nearest(name, channels)
        for name in term.arguments:
            if name not in readable + own:
                return nearest(name, readable + own)
    return ""


def _in_short(effect: Effect) -> str:
    meaning = textwrap.fill(effect.meaning, 78, initial_indent="  ", subsequent_indent="  ")
    return f"{effect.name}\n{meaning}\n  {effect.equation}\n  source: {effect.source}"
