"""The hand: named parameter values and the effects in its model."""

import math
from collections.abc import Iterable, Mapping
from dataclasses import replace

import numpy as np

from hannes.contact.shapes import frame, sections
from hannes.core.effect import Effect, joined
from hannes.core.errors import BadInput
from hannes.core.parameter import ParameterSet
from hannes.simulation.catalogue import effect as find_effect
from hannes.simulation.compiler.assemble import Compiled, assemble
from hannes.simulation.hand import anatomy, variables
from hannes.simulation.hand.anatomy import FINGERS
from hannes.simulation.hand.model import EQUATIONS
from hannes.simulation.hand.packed_shares import SHARES
from hannes.simulation.hand.variables import LANES

# What the object's sections depend on.
_POSE = ("turn", "tilt_x", "tilt_y")
_CUT = {f"object.{name}" for name in ("radius", "half_x", "half_y", "z", *_POSE)} | {
    f"{finger}.{name}" for finger in FINGERS for name in ("mount_z", "radius")
}


class Hand:
    """A Hannes hand: immutable; `with_values` and `with_effects` return changed copies."""

    def __init__(self, effects: Iterable[Effect | str] = ()) -> None:
        found = [find_effect(each) if isinstance(each, str) else each for each in effects]
        if lost := [each.name for each in found if not each.terms]:
            raise BadInput(f"{lost[0]} is a fault of a part: give that its own value in [[finger]]")
        self.effects = joined((), found)
        own = (
            replace(each, name=effect.full_name(each.name))
            for effect in self.effects
            for each in effect.parameters
        )
        self.parameters = ParameterSet((*variables.PARAMETERS, *own))

    def with_values(self, values: Mapping[str, float]) -> "Hand":
        """Return a copy with other SI values by full name; BadInput on unknown name or bounds."""
        return self._copy(self.effects, self.parameters.with_values(values))

    def with_effects(self, *effects: Effect | str) -> "Hand":
        """Return a copy whose model also has `effects`, at `off` until given a value."""
        found = [find_effect(each) if isinstance(each, str) else each for each in effects]
        grown = Hand(joined(self.effects, found))
        return self._copy(grown.effects, grown.parameters.with_values(dict(self.parameters)))

    def _copy(self, effects: tuple[Effect, ...], parameters: ParameterSet) -> "Hand":
        copy = Hand.__new__(Hand)
        copy.effects, copy.parameters = effects, parameters
        return copy

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Hand):
            return NotImplemented
        return self.effects == other.effects and self.parameters == other.parameters

    def __hash__(self) -> int:
        return hash((self.effects, tuple(self.parameters.values())))

    def __repr__(self) -> str:
        names = ", ".join(each.name for each in self.effects)
        with_effects = [f"effects=[{names}]"] if names else []
        return f"Hand({', '.join(with_effects + self.parameters.changed())})"

    def present_effects(self) -> tuple[Effect, ...]:
        """Effects with an amplitude that is not `off`; the others are left out of the model."""
        return tuple(
            each
            for each in self.effects
            if any(self.parameters[each.full_name(a.name)] != a.off for a in each.amplitudes)
        )

    def compiled(self, effects: tuple[Effect, ...] | None = None) -> Compiled:
        """Entry points of the model with its present effects, or with exactly `effects`."""
        return assemble(EQUATIONS, self.present_effects() if effects is None else effects)

    def equations(self) -> str:
        """Text of the assembled equations, effects included."""
        return self.compiled().text

    def vector(self, shape: str | None, effects: tuple[Effect, ...] | None = None) -> np.ndarray:
        """Pack all values for the compiled code, shape (parameter layout,), SI units.

        `shape` is that of the object, None where there is none.
        """
        values, effects = self.parameters, self.present_effects() if effects is None else effects
        packed = [values[name] for name in variables.PACKED]
        for place, share in SHARES.items():
            packed[place] *= values[share]
        packed += self._derived(shape, effects)
        for effect in effects:
            packed += [values[effect.full_name(each.name)] for each in effect.parameters]
        return np.array(packed)

    def _derived(self, shape: str | None, effects: tuple[Effect, ...]) -> list[float]:
        """Values of `DERIVED_SLOTS`, one after the other."""
        turns = any("object_angle" in term.writes for each in effects for term in each.terms)
        derived = {} if shape is None else self._sections(shape, turns)
        derived["distal"] = [0.0, 1.0] * (LANES // 2)
        slots = (derived.get(slot.name, [0.0] * slot.size) for slot in variables.DERIVED_SLOTS)
        return [value for each in slots for value in each]

    def vectors(
        self,
        shape: str | None,
        count: int,
        columns: Mapping[str, np.ndarray],
        effects: tuple[Effect, ...],
    ) -> np.ndarray:
        """Pack `count` vectors that differ in `columns` (full name -> (count,)), one a row.

        A column is copied to its places at once. The object's sections are cut once for all rows
        that have them in common.
        """
        base = self.vector(shape, effects)
        own = [effect.full_name(each.name) for effect in effects for each in effect.parameters]
        table = np.tile(base, (count, 1))
        for place, name in (*enumerate(variables.PACKED), *enumerate(own, base.size - len(own))):
            share = SHARES.get(place, "")
            if name in columns or share in columns:
                table[:, place] = columns.get(name, self.parameters[name])
                if share:
                    table[:, place] *= columns.get(share, self.parameters[share])
        cuts = {name: column for name, column in columns.items() if name in _CUT}
        if cuts and shape is not None:
            first = len(variables.PACKED)
            table[:, first : base.size - len(own)] = self._derived_rows(shape, cuts, effects)
        return table

    def _derived_rows(
        self, shape: str, cuts: Mapping[str, np.ndarray], effects: tuple[Effect, ...]
    ) -> list[list[float]]:
        """Values of `DERIVED_SLOTS` for each row of what an object's sections depend on."""
        made: dict[tuple[float, ...], list[float]] = {}
        rows = list(zip(*(column.tolist() for column in cuts.values()), strict=True))
        for row in dict.fromkeys(rows):
            there = self.with_values(dict(zip(cuts, row, strict=True)))
            made[row] = there._derived(shape, effects)
        return [made[row] for row in rows]

    def _sections(self, shape: str, turns: bool) -> dict[str, list[float]]:
        """Values of what an object comes to, by slot; `turns`: an effect turns it."""
        values = self.parameters
        offsets = [values[f"{finger}.mount_z"] - values["object.z"] for finger in FINGERS]
        radius, half_x, half_y = (values[f"object.{n}"] for n in ("radius", "half_x", "half_y"))
        cuts = sections(shape, radius, half_x, half_y, offsets)
        middle = sections(shape, radius, half_x, half_y, [0.0])[0]
        pose = [0.0 if shape == "sphere" else values[f"object.{name}"] for name in _POSE]
        half = {axis: [cut[n] for cut in cuts] for n, axis in enumerate("xy")}
        tilts = zip("xy", pose[1:], strict=True)
        aside = {axis: [each * math.tan(tilt) for each in offsets] for axis, tilt in tilts}
        flat = 1.0 if any((*half["x"], *half["y"])) else 0.0
        if any(pose[1:]) or (flat and (turns or pose[0])):
            flat = 2.0
        reach = [
            values[f"{finger}.radius"] + cut[2] if cut[2] > 0.0 else -1.0
            for finger, cut in zip(FINGERS, cuts, strict=True)
            for _ in range(2)
        ]
        turned = zip(("frame_xx", "frame_xy", "frame_yx", "frame_yy"), frame(*pose), strict=True)
        cut = zip(("middle_half_x", "middle_half_y", "middle_radius"), middle, strict=True)
        return {
            "object_present": [1.0],
            "object_flat": [flat],
            **{f"section_half_{axis}": values for axis, values in half.items()},
            **{f"section_aside_{axis}": values for axis, values in aside.items()},
            **{name: [value] for name, value in (*cut, *turned)},
            "reach": reach + [-1.0] * (LANES - len(reach)),
        }

    def rest(self, compiled: Compiled) -> np.ndarray:
        """State of the open hand at rest, shape (states,)."""
        state = np.zeros(compiled.states.size)
        state[compiled.states["joint_angle"]] = [
            self.parameters[name] for name in anatomy.TABLES["rest"]
        ]
        return state

    def rests(self, compiled: Compiled, vectors: np.ndarray) -> np.ndarray:
        """The same for each row of `vectors`, shape (m, states)."""
        states = np.zeros((vectors.shape[0], compiled.states.size))
        angles = states[:, compiled.states["joint_angle"]]
        angles[:] = vectors[:, compiled.parameters["rest"]][:, : angles.shape[1]]
        return states

    def __str__(self) -> str:
        """Stages with their equations, effects, values that differ from the shipped, sources."""
        from hannes.simulation.hand.description import described

        return described(self, EQUATIONS)
