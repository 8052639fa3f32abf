"""A hand described in 80 columns: stages with their equations, effects, changed values, sources.

Another plant is described by its effects and values.
"""

import inspect
import re
import textwrap
from collections.abc import Callable, Iterable
from typing import Protocol

from hannes.core.effect import Effect
from hannes.core.errors import BadInput
from hannes.core.kernels.jit import plain
from hannes.core.model import Model, differences
from hannes.core.parameter import Parameter
from hannes.simulation.compiler.assemble import Equations, jacobian_kind
from hannes.simulation.hand import equations

COLUMNS = 80
_STAGE = re.compile(r"^ +(?:[\w, ]+ = )?(\w+)\(.*\)$", re.MULTILINE)
_FORMULA = re.compile(r" [+=] | - |tanh")
_CALL = re.compile(r"\b([a-z_]+)\(")


class HandModel(Model, Protocol):
    """A hand, as far as it is described here."""

    def present_effects(self) -> tuple[Effect, ...]:
        """Effects with an amplitude that is not `off`."""


def described(hand: HandModel, written: Equations) -> str:
    """What `print(hand)` shows of a hand whose equations are `written`."""
    lines = ["Hannes hand: five fingers, two carts, one motor", ""]
    lines += ["Stages of the model, in order (their text: hannes hand --equations)"]
    lines += _stages(hand.present_effects(), written)
    lines += ["", "Effects", *(_effects(hand) or ["  none beyond the base model"])]
    lines += _slow(hand.present_effects(), written)
    lines += ["", "Values that differ from the shipped hand", *(_changed(hand) or ["  none"])]
    lines += ["", "Sources of the values (each of them: hannes hand --values)"]
    return "\n".join([*lines, *_sources(hand.parameters.declared.values())])


def plant_described(plant: Model, name: str) -> str:
    """What `hannes hand` shows of a plant other than the hand, known as `name`."""
    lines = [f'The plant "{name}"', "", "Effects", *(_effects(plant) or ["  none"])]
    lines += ["", "Values that differ from the declared ones", *(_changed(plant) or ["  none"])]
    return "\n".join([*lines, "", "Values", value_table(plant)])


def equations_of(model: Model) -> str:
    """Text of the assembled equations; BadInput where a user's own plant has none."""
    text = getattr(model, "equations", None)
    if text is None:
        raise BadInput("this plant does not print its equations; leave out --equations")
    return str(text())


def value_table(hand: Model) -> str:
    """Every value with unit, meaning and source, grouped by part."""
    lines, part = [], ""
    for name, declared in hand.parameters.declared.items():
        value = hand.parameters[name]
        if declared.shared and value == declared.value:
            continue  # a joint like all of its kind
        if name.split(".")[0] != part:
            part = name.split(".")[0]
            lines.append(part)
        left = f"  {name.partition('.')[2]:<21}{value:<11.5g} {declared.unit:<10}"
        source = declared.source if value == declared.value else f"here, not {declared.value:.5g}"
        lines.append(f"{left} {declared.doc} ({source})")
    return "\n".join(lines)


def _stages(effects: Iterable[Effect], written: Equations) -> list[str]:
    """One entry a stage, from the stage's own docstring; effects under the stage they join."""
    joined: dict[str, list[str]] = {}
    for effect in effects:
        for term in effect.terms:
            joined.setdefault(written.stage_of(term.writes[0]), []).append(effect.name)
    lines = []
    for stage in _STAGE.findall(inspect.getsource(equations.equations)):
        lines += _entry(stage, _headline(getattr(equations, stage)))
        lines += [line for law in _laws(stage) for line in _wrapped(law, 14)]
        lines += [f"{'':14}+ effect {name}" for name in dict.fromkeys(joined.get(stage, ()))]
    return lines


def _slow(effects: Iterable[Effect], written: Equations) -> list[str]:
    """A line on effects with which the integrator's Jacobian is not the structured one."""
    kind = jacobian_kind(written, effects)
    return [] if kind == "structured" else _wrapped(f"slower to simulate: {kind}", 2)


def _headline(function: Callable[..., object]) -> str:
    """First paragraph of a docstring, on one line."""
    return " ".join((inspect.getdoc(function) or "").split("\n\n")[0].split()).replace("`", "")


def _laws(stage: str) -> list[str]:
    """Formulas of dynamics, contact and control that a stage calls, but for its own over again."""
    text = (_headline(each) for each in _called(stage))
    own = _headline(getattr(equations, stage))
    return [each for each in text if _FORMULA.search(each) and each[:7] not in own]


def _called(stage: str) -> list[Callable[..., object]]:
    """Kernels that a stage calls, also through functions of equations.py, in order."""
    found: dict[str, Callable[..., object]] = {}
    for name in _CALL.findall(inspect.getsource(getattr(equations, stage))):
        function = plain(getattr(equations, name, None))
        if name != stage and inspect.isfunction(function):
            inner = _called(name) if function.__module__ == equations.__name__ else [function]
            found |= {each.__name__: each for each in inner}
    return list(found.values())


def _entry(name: str, text: str) -> list[str]:
    head = f"  {name.replace('position_reference', 'reference'):<12}"
    return textwrap.wrap(text, COLUMNS, initial_indent=head, subsequent_indent=" " * 14)


def _effects(hand: Model) -> list[str]:
    lines = []
    for each in hand.effects:
        values = [hand.parameters[each.full_name(a.name)] for a in each.amplitudes]
        vanished = values == [a.off for a in each.amplitudes]
        off = " (off: vanishes from the model)" if vanished else ""
        lines.append(f"  {each.name}{off}")
        lines += [*_wrapped(each.equation, 4), *_wrapped(f"source: {each.source}", 4)]
    return lines


def _wrapped(text: str, indent: int) -> list[str]:
    return textwrap.wrap(
        text, COLUMNS, initial_indent=" " * indent, subsequent_indent=" " * (indent + 2)
    )


def _changed(hand: Model) -> list[str]:
    lines = []
    for name, value in differences(hand).items():
        declared = hand.parameters.require(name)
        lines.append(f"  {name} = {value:.6g} {declared.unit}  (shipped: {declared.value:.6g})")
    return lines


def _sources(declared: Iterable[Parameter]) -> list[str]:
    """Published sources with the values they gave; everything else is a choice, and says so."""
    by_source: dict[str, list[str]] = {}
    for each in (each for each in declared if not each.shared):
        by_source.setdefault(each.source, []).append(each.name)
    lines = []
    for source, names in by_source.items():
        if not source.startswith("choice"):
            lines += _wrapped(f"{source}: {', '.join(names)}", 2)
    chosen = sum(len(names) for source, names in by_source.items() if source.startswith("choice"))
    return [*lines, f"  choice, no published value: the other {chosen}"]
