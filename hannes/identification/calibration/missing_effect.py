"""Whether a residual looks like an effect that the model lacks (score test, Rao 1948).

Uncertain parameters follow a missing effect, and hide it: what is left may be as small as repeats
differ by, and an identified value far off. So each effect that could be added is: its change of
every run at a small size, beyond what all parameters can do within their scatter, is compared with
what is left there. Noise is as the fit took it, which is more than there is. Effects outside the
catalogue are represented by the generic disturbances of `hannes diagnose`.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from hannes.core.effect import Effect
from hannes.core.parameter import Parameter
from hannes.core.recording.recording import Recording
from hannes.identification.calibration.linearisation import State
from hannes.identification.calibration.tuning import CALIBRATION
from hannes.identification.diagnosis.generic_disturbances import EFFECTS as GENERIC
from hannes.identification.diagnosis.generic_disturbances import GENERIC_NAMES
from hannes.identification.diagnosis.repeat_groups import Channels, nominal_values
from hannes.identification.diagnosis.score_test import shapes
from hannes.identification.effect_words import effect_words
from hannes.plants.part_fault import compiled_effects
from hannes.plants.protocol import Plant


@dataclass(frozen=True)
class MissingEffect:
    """The effect that what is left resembles most.

    name:       of the effect, in words; "" where none was tested
    deviations: how far its size would lie from none, in standard deviations, linearly
    p_value:    that chance gives as much to any of those tested
    tested:     number of effects
    """

    name: str = ""
    deviations: float = 0.0
    p_value: float = 1.0
    tested: int = 0

    @property
    def likely(self) -> bool:
        """Whether the model likely lacks something."""
        return self.p_value < CALIBRATION.missing_p_value

    @property
    def sentence(self) -> str:
        """The result in words; "" where none was tested."""
        if not self.tested:
            return ""
        size = f"by {self.deviations:.1f} standard deviations, linearly (p = {self.p_value:.2g})"
        if self.likely:
            return (
                f"What is left looks like {self.name}, {size}: the model lacks that or something "
                "like it, and no interval here allows for that; see `hannes diagnose`"
            )
        return (
            f"Of {self.tested} effects that the model may lack none shows; most does "
            f"{self.name}, {size}"
        )


@dataclass(frozen=True)
class _Direction:
    """A small step of one of an effect's parameters: values by full name, and allowed signs."""

    effect: Effect
    values: dict[str, float]
    both: bool


def missing_effect(found: State, effects: Sequence[Effect]) -> MissingEffect:
    """The effect that is left most; none where the plant cannot simulate runs alike."""
    plant = found.model.plant
    present = {each.name for each in plant.effects}
    every = compiled_effects((*effects, *GENERIC))  # each joint is uncertain for itself already
    tried = [each for each in every if each.name not in present and not plant.accepts(each)]
    directions = [each for effect in tried for each in _directions(effect)]
    whole = plant.with_effects(*tried)
    alike = getattr(whole, "alike", None)
    if not directions or alike is None:
        return MissingEffect()
    far = _deviations(found, _changes(found, whole, alike, directions))
    chances = [_chance(size, each.both) for size, each in zip(far, directions, strict=True)]
    least = int(np.argmin(chances))
    name = directions[least].effect.name
    return MissingEffect(
        GENERIC_NAMES.get(name, effect_words(name)),
        float(far[least]),
        min(1.0, chances[least] * len(tried)),
        len(tried),
    )


def _directions(effect: Effect) -> list[_Direction]:
    """Of each amplitude at each shape."""
    return [
        _Direction(effect, {**shape, effect.full_name(each.name): _step(each)}, _both(each))
        for shape in shapes(effect)
        for each in effect.amplitudes
    ]


def _step(amplitude: Parameter) -> float:
    """A small value, away from the end of the range at which it may be off."""
    low, high = amplitude.bounds
    off, step = amplitude.off or 0.0, CALIBRATION.effect_step * (high - low)
    return off + step if off + step <= high else off - step


def _both(amplitude: Parameter) -> bool:
    low, high = amplitude.bounds
    return low < (amplitude.off or 0.0) < high


def _changes(
    found: State, whole: Plant, alike: Callable[..., Any], directions: Sequence[_Direction]
) -> list[np.ndarray]:
    """Change of every run's vector in each direction, (directions, n) each; 0 where one fails."""
    model, changes = found.model, [np.zeros(0)] * len(found.model.views)
    for group in model.groups:
        recording = model.views[group[0]].recording
        base = {**dict(whole.parameters), **_values(found, whole, recording)}
        rows = [base, *({**base, **each.values} for each in directions)]
        names = {*found.all_values, *(name for each in directions for name in each.values)}
        columns = {name: np.array([row[name] for row in rows]) for name in names}
        made = alike(columns, recording, tuple(whole.judged))
        for place in group:
            changes[place] = _apart(found, place, made)
    return changes


def _values(found: State, whole: Plant, recording: Recording) -> dict[str, float]:
    """Fitted and uncertain parameters, and what a run's experiment says of its own object [SI]."""
    values, own = found.all_values, getattr(whole, "own", None)
    if own is not None:
        stated = nominal_values(whole, recording)[0]
        given = [name for name in own(recording)[1] if stated[name] != whole.parameters[name]]
        values |= {name: stated[name] for name in given}
    return values


def _apart(found: State, place: int, made: Sequence[Channels | None]) -> np.ndarray:
    """Of runs from the first one, in the vector of one recording, shape (runs - 1, n)."""
    view, offset = found.model.views[place], float(found.start_offsets[place])
    rows = np.zeros((len(made) - 1, view.measured.size))
    if made[0] is None:
        return rows
    here = view.of(made[0], offset)
    for row, each in zip(rows, made[1:], strict=True):
        if each is not None:
            row[:] = np.nan_to_num(view.of(each, offset) - here)
    return rows


def _deviations(found: State, changes: Sequence[np.ndarray]) -> np.ndarray:
    """Size of each change that fits what is left best, in its standard deviations, all else free.

    Residuals are simulated minus measured.
    """
    rows, jacobian = found.together(changes), found.jacobian()
    left = found.whitened_residual(found.residuals)
    weight = found.scales.prior**2
    inverse = np.linalg.inv(jacobian @ jacobian.T + np.diag(weight))
    rest = left - jacobian.T @ (inverse @ (jacobian @ left + weight * found.x))
    shared = rows @ jacobian.T
    spread = np.sum(rows**2, axis=1) - np.einsum("ij,jk,ik->i", shared, inverse, shared)
    informed = spread > CALIBRATION.no_information * np.maximum(np.sum(rows**2, axis=1), 1e-30)
    return np.where(informed, -(rows @ rest) / np.sqrt(np.where(informed, spread, 1.0)), 0.0)


def _chance(deviations: float, both: bool) -> float:
    """Probability of so far or farther in an allowed direction."""
    from scipy.stats import norm

    return float(2.0 * norm.sf(abs(deviations)) if both else norm.sf(deviations))
