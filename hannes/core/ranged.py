"""Effects within a machine's own bounds: the ranges that ship are those of a hand."""

from collections.abc import Iterable, Mapping
from dataclasses import replace

from hannes.core.effect import Effect
from hannes.core.errors import nearest
from hannes.core.parameter import Parameter

Bounds = tuple[float, float]


def own_ranges(plant: object) -> Mapping[str, Bounds]:
    """Bounds of this machine by full name [SI]; a plant may leave out the attribute `ranges`."""
    return getattr(plant, "ranges", {})


def ranged(effect: Effect, ranges: Mapping[str, Bounds]) -> Effect:
    """The effect with a machine's own bounds, by full name [SI]; the same where it has none.

    A value that lies outside them is moved to the nearer bound.
    """
    found = tuple(
        _ranged(each, ranges.get(effect.full_name(each.name))) for each in effect.parameters
    )
    return effect if found == effect.parameters else replace(effect, parameters=found)


def ranges_of_nothing(plant: object, effects: Iterable[Effect]) -> str:
    """Which of a machine's bounds is of no effect at all, in words; "" where each has one."""
    known = {each.full_name(parameter.name) for each in effects for parameter in each.parameters}
    strange = [name for name in own_ranges(plant) if name not in known]
    if not strange:
        return ""
    return f'its ranges have "{strange[0]}", which no effect has{nearest(strange[0], known)}'


def _ranged(parameter: Parameter, bounds: Bounds | None) -> Parameter:
    if bounds is None or bounds == parameter.bounds:
        return parameter
    low, high = bounds
    tried = tuple(each for each in parameter.tried if low <= each <= high)
    value = min(max(parameter.value, low), high)
    return replace(parameter, bounds=bounds, value=value, tried=tried)
