"""Which states an effect adds to a finger and which to the core, and whether arrow.py holds.

Decided from what each kernel reads and where it joins, before anything is compiled.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from types import ModuleType

from hannes import arrow as arrow_text
from hannes.effect import Effect, Term
from hannes.layout import Layout, Slot

PARTS = {
    **dict.fromkeys(("position_reference", "sense", "control", "drive"), "motor"),
    **dict.fromkeys(("leader", "gear", "carts"), "wires"),
    **dict.fromkeys(("joints", "contact", "press", "inertia"), "fingers"),
}
PER_FINGER = {"joint": 2, "phalanx": 2, "finger": 1}
BOTH, MOTOR_ONLY, WIRES_ONLY = 0, 1, 2  # PART in arrow.py
_OF_MOTOR = ("position_integral", "position_lag", "current_integral", "current_lag")
_OF_WIRES = ("cart_position", "cart_speed")
_TAKEN_UP = ("excursion", "excursion_rate")
_FROM_WIRES = ("leader_pull", "cart_friction", "tendon_tension")


@dataclass
class Arrow:
    """The constants of arrow.py for one set of effects; `broken` says why it does not hold."""

    core: list[int] = field(default_factory=list)
    own: list[list[int]] = field(default_factory=lambda: [[] for _ in range(5)])
    part: list[int] = field(default_factory=list)
    cart: list[int] = field(default_factory=lambda: [0, 0, 1, 1, -1])
    seen: list[int] = field(default_factory=list)
    timed: bool = False
    held: bool = True
    paired: bool = True
    broken: str = ""

    def constants(self) -> dict[str, str]:
        """Text of the constants by name."""
        lists = {"CORE": self.core, "PART": self.part, "CART": self.cart, "SEEN": self.seen}
        numbers = {"SIZE": len(self.own[0]), "COUNT": len(self.core), "SEEING": len(self.seen)}
        flags = {"TIMED": self.timed, "HELD": self.held, "PAIRED": self.paired}
        return {
            **{name: f"np.array({values}, np.int64)" for name, values in lists.items()},
            "OWN": f"np.array({self.own}).T.copy()",
            **{name: str(value) for name, value in (numbers | flags).items()},
            "KINKS": "30",
            "ROWS": str(5 + len(self.core)),
        }


def arrow(
    states: Layout, channels: Layout, stage_of: Callable[[str], str], effects: tuple[Effect, ...]
) -> tuple[ModuleType, dict[str, str], str]:
    """Place all `states`, those of `effects` included; see Equations.shape for what returns."""
    found = Arrow()
    stages = {term.writes[0]: stage_of(term.writes[0]) for each in effects for term in each.terms}
    elsewhere = _states_of_other_stages(effects, stages)
    for slot in states.slots:
        places = range(states[slot.name].start, states[slot.name].stop)
        if slot.axis in PER_FINGER and slot.name not in elsewhere:
            share = PER_FINGER[slot.axis]
            for k in places:
                found.own[(k - places.start) // share].append(k)  # angles, speeds, effects'
            continue
        part = MOTOR_ONLY if slot.name in _OF_MOTOR else BOTH
        part = WIRES_ONLY if slot.name in _OF_WIRES else part
        found.core += places
        found.part += [part] * slot.size
        found.cart += [0, 1] if slot.name in _OF_WIRES else [-1] * slot.size
    for effect in effects:
        for term in effect.terms:
            _join(found, effect, term, states, channels, PARTS[stages[term.writes[0]]])
    found.seen.sort()
    return arrow_text, found.constants(), found.broken


def _states_of_other_stages(effects: tuple[Effect, ...], stages: dict[str, str]) -> set[str]:
    """Full names of effects' states whose rates are not set in a finger's stage."""
    return {
        f"{effect.name}.{name}"
        for effect in effects
        for term in effect.terms
        for name in term.states
        if PARTS[stages[term.writes[0]]] != "fingers"
    }


def _join(
    found: Arrow, effect: Effect, term: Term, states: Layout, channels: Layout, part: str
) -> None:
    axis = channels.slot(term.writes[0]).axis
    found.timed = found.timed or (part != "motor" and "t" in term.arguments)
    found.paired = found.paired and not (part == "wires" and term.states)
    for name in term.states:
        slot = states.slot(f"{effect.name}.{name}")
        if part == "fingers" and slot.axis not in PER_FINGER:
            found.broken = f"{effect.name}.{name} belongs to no finger"
    for slot in _read_states(effect, term, states):
        why = _reads_state(found, slot, states, axis, part, "torque_constant" in term.writes)
        found.broken = found.broken or (why and f"{effect.name} {why}")
    for name in term.arguments:
        if name in channels and channels.slot(name).axis:
            found.held = found.held and (part != "fingers" or name != "tendon_tension")
            found.paired = found.paired and part != "wires"
            why = _reads_channel(channels.slot(name), axis, part)
            found.broken = found.broken or (why and f"{effect.name} {why}")


def _read_states(effect: Effect, term: Term, states: Layout) -> Iterator[Slot]:
    for name in term.arguments:
        for full in (f"{effect.name}.{name}", name):
            if full in states:
                yield states.slot(full)
                break


def _reads_state(
    found: Arrow, slot: Slot, states: Layout, axis: str, part: str, to_torque: bool
) -> str:
    """Note who reads a state; say what the arrow has no place for."""
    first = states[slot.name].start
    if first not in found.core:
        return "" if part == "fingers" and _own(slot, axis) else f"reads all of {slot.name}"
    for n in range(found.core.index(first), found.core.index(first) + slot.size):
        if part == "fingers" and n not in found.seen:
            found.seen.append(n)
        reader = {"motor": MOTOR_ONLY, "wires": WIRES_ONLY}.get(part, found.part[n])
        if found.part[n] != reader or to_torque:
            found.part[n] = BOTH
    return ""


def _reads_channel(slot: Slot, axis: str, part: str) -> str:
    if part == "motor":
        return f"reads {slot.name} in the stages of the motor"
    if part == "wires":
        return "" if slot.name in (*_TAKEN_UP, *_FROM_WIRES) else f"reads {slot.name} in the wires"
    if slot.name in _FROM_WIRES[:2]:
        return f"reads {slot.name} in the fingers"
    return "" if _own(slot, axis) else f"reads all of {slot.name}"


def _own(slot: Slot, axis: str) -> bool:
    """Tell whether a kernel called along `axis` gets its own finger's element of a slot."""
    if axis not in PER_FINGER or slot.axis not in PER_FINGER:
        return False
    return slot.axis == "finger" or PER_FINGER[slot.axis] == PER_FINGER[axis]
