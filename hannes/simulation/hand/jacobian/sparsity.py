"""Which states an effect adds to a finger and which to the border, and whether arrowhead.py holds.

Decided from what each kernel reads and where it joins, before anything is compiled.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from hannes.core.effect import Effect, Term
from hannes.core.layout import Layout, Slot
from hannes.simulation.compiler.assemble import Shape
from hannes.simulation.compiler.autodiff.values import NotDifferentiable
from hannes.simulation.compiler.expansion import Layouts
from hannes.simulation.hand.jacobian import (
    arrowhead,
    drivetrain_block,
    finger_blocks,
    finger_differences,
    finger_effect_terms,
    sparse_lu,
)

PARTS = {
    **dict.fromkeys(
        ("position_reference", "probe", "sense", "sample", "control", "drive"), "motor"
    ),
    **dict.fromkeys(("leader", "gear", "carts"), "wires"),
    **dict.fromkeys(("joints", "contact", "press", "sense_forces", "inertia"), "fingers"),
}
PER_FINGER = {"joint": 2, "phalanx": 2, "finger": 1}
_LOGGED = ("logged_force", "logged_sensor")
_SHARED = {"joint_torque", *_LOGGED}  # by both joints of a finger
_TAKEN_UP = ("excursion", "excursion_rate")
_WHOLE = ("y", "dy", "c", "out", "reference", "memory")
_OF_CART = ("leader_pull", "cart_friction", "follower_slip", "follower_loss")
_FROM_WIRES = (*_OF_CART, "tendon_tension")


@dataclass
class Arrowhead:
    """The constants of arrowhead.py for one set of effects; `broken` says why it does not hold."""

    border: list[int] = field(default_factory=list)
    own: list[list[int]] = field(default_factory=lambda: [[] for _ in range(5)])
    seen: list[int] = field(default_factory=list)
    timed: bool = False  # fingers feel the time
    held: bool = True
    plain_fingers: bool = True  # finger_blocks.py holds
    broken: str = ""
    terms: list[finger_effect_terms.DifferentiatedTerm] = field(default_factory=list)
    kinds: list[tuple[str, int]] = field(default_factory=list)  # own states: name, which of two
    apart: set[str] = field(default_factory=set)  # of joints or phalanges, each for itself
    trailing: set[str] = field(default_factory=set)  # that only force sensors read

    def constants(self, pattern: sparse_lu.Pattern) -> dict[str, str]:
        """Text of the constants by name."""
        lists = {"BORDER": self.border, "SEEN": self.seen}
        numbers = {"SIZE": len(self.own[0]), "COUNT": len(self.border), "SEEING": len(self.seen)}
        return {
            **{name: f"np.array({values}, np.int64)" for name, values in lists.items()},
            "OWN": f"np.array({self.own}).T.copy()",
            **{name: str(value) for name, value in numbers.items()},
            "HELD": str(self.held),
            "KINKS": "30",
            "ROWS": str(5 + len(self.border)),
            "ENTRIES": str(sparse_lu.entries(pattern)),
            "TOUCHED": f"np.array({finger_effect_terms.touched(self.terms)}, np.int64)",
        }

    def pattern(self, border: drivetrain_block.Border) -> sparse_lu.Pattern:
        """Where tensions and border may depend on each other, be it through the fingers."""
        full = []
        for i, (couplings, needed) in enumerate(zip(border.couplings, border.needed, strict=True)):
            through = [any(couplings) and n in self.seen for n in range(len(needed))]
            row = [*couplings, *(a or b for a, b in zip(needed, through, strict=True))]
            row[i] = True
            full.append(row)
        return full

    def fingers(self, layouts: Layouts, names: Mapping[str, Any]) -> list[str]:
        """What finger_blocks.py needs beside itself."""
        if not self.plain_fingers:
            return []
        return [finger_effect_terms.text(self.terms, len(self.kinds), layouts, names)]

    def own_pattern(self) -> sparse_lu.Pattern:
        """Where the rates of a finger's own states may depend on these."""
        if self.plain_fingers:
            return finger_effect_terms.pattern(self.terms, len(self.kinds))
        return [
            [self._depends(i, j) for j in range(len(self.kinds))] for i in range(len(self.kinds))
        ]

    def _depends(self, i: int, j: int) -> bool:
        (row, link), (column, other) = self.kinds[i], self.kinds[j]
        if i < 2:
            return j == i + 2
        if column in self.trailing:
            return i == j
        return i < 4 or j < 4 or link == other or not {row, column} <= self.apart


def shape(
    layouts: Layouts, source: str, names: Mapping[str, Any], stage_of: Callable[[str], str]
) -> Shape:
    """Place all states, those of effects included; `source` has the stages with their calls."""
    states, effects = layouts.y, layouts.effects
    stages = {term.writes[0]: stage_of(term.writes[0]) for each in effects for term in each.terms}
    found = _placed(states, _homes(effects, stages))
    for effect in effects:
        for term in effect.terms:
            _join(found, effect, term, layouts, stages[term.writes[0]])
    found.trailing = set(_trailing(effects))
    logged = [each.channel for each in found.terms if each.logged]
    found.plain_fingers &= len(set(logged)) == len(logged)  # else one reads what another adds
    if found.broken:
        return Shape((arrowhead,), {}, "", found.broken)
    found.seen.sort()
    try:
        border = drivetrain_block.differentiated(
            source, names, layouts.c, found.border, found.timed
        )
        own = found.fingers(layouts, names)
    except NotDifferentiable as error:
        return Shape((arrowhead,), {}, "", f"no derivative is known of {error}")
    pattern = found.pattern(border)
    written = sparse_lu.text(pattern, border.couplings, found.border, found.seen)
    solved = sparse_lu.fingers(found.own_pattern(), found.own)
    written = "\n\n".join([written, solved, border.text, *own])
    fingers = finger_blocks if found.plain_fingers else finger_differences
    return Shape((fingers, arrowhead), found.constants(pattern), written, "", arrowhead.FIELDS)


def _placed(states: Layout, homes: Mapping[str, str]) -> Arrowhead:
    """Put each state into the border or into its finger."""
    found = Arrowhead()
    for slot in states.slots:
        places = range(states[slot.name].start, states[slot.name].stop)
        if slot.axis in PER_FINGER and homes.get(slot.name, "fingers") == "fingers":
            share = PER_FINGER[slot.axis]
            for k in places:
                found.own[(k - places.start) // share].append(k)  # angles, speeds, effects'
            found.kinds += [(slot.name, link) for link in range(share)]
        else:
            found.border += places
    return found


def _homes(effects: tuple[Effect, ...], stages: dict[str, str]) -> dict[str, str]:
    """The part whose stages set the rates of each effect's states, by full name."""
    return {
        f"{effect.name}.{name}": PARTS[stages[term.writes[0]]]
        for effect in effects
        for term in effect.terms
        for name in term.states
    }


def _trailing(effects: tuple[Effect, ...]) -> Iterator[str]:
    """Full names of states that only their own term reads, which only adds to logged forces."""
    terms = [(effect, term) for effect in effects for term in effect.terms]
    for effect, term in terms:
        if set(term.writes) <= set(_LOGGED) and len(term.states) == 1:
            others = {name for _, each in terms if each is not term for name in each.arguments}
            if not others & {*term.states, *term.writes}:
                yield f"{effect.name}.{term.states[0]}"


def _join(found: Arrowhead, effect: Effect, term: Term, layouts: Layouts, stage: str) -> None:
    """Note what one kernel of an effect adds to the structure."""
    states, channels = layouts.y, layouts.c
    part, axis = PARTS[stage], channels.slot(term.writes[0]).axis
    own = {each.name for each in effect.parameters}
    arguments = [name for name in term.arguments if name not in own]
    reads = tuple(_read_states(effect, arguments, states))
    arrays = [channels.slot(n) for n in arguments if n in channels and channels.slot(n).axis]
    whys = [_reads_state(found, slot, states, axis, part) for slot in reads]
    whys += [_reads_channel(slot, axis, part) for slot in arrays]
    whys += [f"reads all of {name}" for name in arguments if name in _WHOLE]
    whys += [
        f"has a state {name} of no finger"
        for name in term.states
        if part == "fingers" and states.slot(f"{effect.name}.{name}").axis not in PER_FINGER
    ]
    found.broken = found.broken or next((f"{effect.name} {why}" for why in whys if why), "")
    if part == "fingers":
        names = {slot.name for slot in arrays}
        own_states = {f"{effect.name}.{name}" for name in term.states}
        found.plain_fingers &= finger_effect_terms.fits(effect, term, layouts)
        rows = {
            name: found.kinds.index((f"{effect.name}.{name}", 0))
            for name in term.states
            if not found.broken
        }
        found.terms.append(finger_effect_terms.DifferentiatedTerm(effect, term, rows))
        found.timed |= "t" in arguments
        found.apart |= own_states if PER_FINGER.get(axis) == 2 and not names & _SHARED else set()
        found.held &= not names & {"tendon_tension", "joint_torque"}


def _read_states(effect: Effect, arguments: list[str], states: Layout) -> Iterator[Slot]:
    for name in arguments:
        for full in (f"{effect.name}.{name}", name):
            if full in states:
                yield states.slot(full)
                break


def _reads_state(found: Arrowhead, slot: Slot, states: Layout, axis: str, part: str) -> str:
    """Note what fingers read of the border; say what the arrow has no place for."""
    first = states[slot.name].start
    if first not in found.border:
        return "" if part == "fingers" and _own(slot, axis) else f"reads all of {slot.name}"
    at = found.border.index(first)
    if part == "fingers":
        found.seen += [n for n in range(at, at + slot.size) if n not in found.seen]
    return ""


def _reads_channel(slot: Slot, axis: str, part: str) -> str:
    if part == "wires":
        return "" if slot.name in (*_TAKEN_UP, *_FROM_WIRES) else f"reads {slot.name} in the wires"
    if slot.name in _OF_CART:
        return f"reads {slot.name} in the fingers"
    return "" if _own(slot, axis) else f"reads all of {slot.name}"


def _own(slot: Slot, axis: str) -> bool:
    """Whether a kernel called along `axis` gets its own finger's element of a slot."""
    if axis not in PER_FINGER or slot.axis not in PER_FINGER:
        return False
    return slot.axis == "finger" or PER_FINGER[slot.axis] == PER_FINGER[axis]
