"""Which states an effect adds to a finger and which to the core, and whether arrow.py holds.

Decided from what each kernel reads and where it joins, before anything is compiled.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

from hannes import (
    arrow,
    core_differences,
    core_slopes,
    elimination,
    finger_differences,
    finger_slopes,
)
from hannes.assemble import Shape
from hannes.effect import Effect, Term
from hannes.layout import Layout, Slot

PARTS = {
    **dict.fromkeys(
        ("position_reference", "probe", "sense", "sample", "control", "drive"), "motor"
    ),
    **dict.fromkeys(("leader", "gear", "carts"), "wires"),
    **dict.fromkeys(("joints", "contact", "press", "tell", "inertia"), "fingers"),
}
PER_FINGER = {"joint": 2, "phalanx": 2, "finger": 1}
BOTH, MOTOR_ONLY, WIRES_ONLY = 0, 1, 2  # PART in arrow.py
_READER = {"motor": MOTOR_ONLY, "wires": WIRES_ONLY}
_OF_MOTOR = ("position_integral", "position_lag", "current_integral", "current_lag")
_OF_WIRES = ("cart_position", "cart_speed")
_CARTS = ("cart_position0", "cart_position1", "cart_speed0", "cart_speed1")
_LEADER = (*_CARTS, "motor_angle", "motor_speed")
# What tensions and wire stages read without effects: core states; fingers' wires.
_READS: dict[str, tuple[str, ...]] = {
    **{f"T{f}": (f"cart_position{f // 2}", f"cart_speed{f // 2}") for f in range(4)},
    "T4": _LEADER,
    "cart_position0": ("cart_speed0",),
    "cart_position1": ("cart_speed1",),
    "cart_speed0": _LEADER,
    "cart_speed1": _LEADER,
    "motor_angle": ("motor_speed",),
    "motor_speed": (*_LEADER, "motor_current"),
}
_ALL = (0, 1, 2, 3, 4)
_BY_WIRE: dict[str, tuple[int, ...]] = {
    **dict.fromkeys(("T0", "T1"), (0, 1)),
    **dict.fromkeys(("T2", "T3"), (2, 3)),
    **dict.fromkeys(("T4", "motor_speed"), (4,)),
    "cart_speed0": (0, 1, 4),
    "cart_speed1": (2, 3, 4),
    **dict.fromkeys(("cart_position0", "cart_position1", "motor_angle"), ()),
}
_TOLD = ("told_force", "told_sensor")
_SHARED = {"joint_torque", *_TOLD}  # by both joints of a finger
_TAKEN_UP = ("excursion", "excursion_rate")
_CONSTANTS = ("slack", "leader_compliance", "follower_compliance")
_ROTOR = ("motor_angle", "motor_speed", "motor_current")
_OF_DRIVE = ("duty", "supply", "voltage")  # hang on all states of the motor's stages
_WHOLE = ("y", "dy", "c", "out", "reference", "hold")
_OF_CART = ("leader_pull", "cart_friction", "follower_slip", "follower_loss")
_FROM_WIRES = (*_OF_CART, "tendon_tension")
_HOMES = dict.fromkeys(_OF_MOTOR, "motor") | dict.fromkeys(_OF_WIRES, "wires")  # of their rates
# What a kernel may read, by stage and axis, where _READS and _BY_WIRE have it anyway.
_USUAL = {
    ("leader", ""): (*_OF_WIRES, "motor_angle", "motor_speed"),
    ("carts", "cart"): (*_OF_WIRES, *_OF_CART),
}


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
    carted: bool = True  # APART in core_differences.py
    alike: bool = True
    plain: bool = True  # no effect reads in the wires' stages what these do not read anyway
    plain_core: bool = True  # core_slopes.py holds
    plain_fingers: bool = True  # finger_slopes.py holds
    broken: str = ""
    names: list[str] = field(default_factory=list)  # of the core's states, one each
    winding: list[str] = field(default_factory=lambda: ["motor_current"])  # rates by the motor only
    kinds: list[tuple[str, int]] = field(default_factory=list)  # own states: name, which of two
    apart: set[str] = field(default_factory=set)  # of joints or phalanges, each for itself
    trailing: set[str] = field(default_factory=set)  # that nothing reads but what sensors tell

    def constants(self) -> dict[str, str]:
        """Text of the constants by name."""
        lists = {"CORE": self.core, "PART": self.part, "CART": self.cart, "SEEN": self.seen}
        numbers = {"SIZE": len(self.own[0]), "COUNT": len(self.core), "SEEING": len(self.seen)}
        flags = {"TIMED": self.timed, "HELD": self.held}
        flags |= {"APART": self.carted, "ALIKE": self.carted and self.alike}
        return {
            **{name: f"np.array({values}, np.int64)" for name, values in lists.items()},
            "OWN": f"np.array({self.own}).T.copy()",
            **{name: str(value) for name, value in (numbers | flags).items()},
            "KINKS": "30",
            "ROWS": str(5 + len(self.core)),
            "ENTRIES": str(elimination.entries(self.pattern()[0])),
        }

    def pattern(self) -> tuple[elimination.Pattern, elimination.Pattern]:
        """Where tensions and core may depend on each other, and on each finger's wire."""
        rows = ["T0", "T1", "T2", "T3", "T4", *self.names]
        reads = {name: self._reads(name) for name in rows}
        takes = [[f in self._taken(row) for f in range(5)] for row in rows]
        needed = [[name in reads[row] for name in self.names] for row in rows]
        for n in self.seen:
            for i, row in enumerate(needed):
                row[n] = row[n] or any(takes[i])
        full = [[f == i or takes[i][f] for f in range(5)] + needed[i] for i in range(len(rows))]
        for n in range(len(self.names)):
            full[5 + n][5 + n] = True
        return full, takes

    def own_pattern(self) -> elimination.Pattern:
        """Where the rates of a finger's own states may depend on these."""
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

    def _taken(self, row: str) -> tuple[int, ...]:
        """Fingers whose wire a tension or the rate of a core state may depend on."""
        if row in self.winding:
            return ()
        return _BY_WIRE.get(row, _ALL) if self.plain else _ALL

    def _reads(self, row: str) -> set[str]:
        """Core states that a tension or the rate of a core state may depend on."""
        if row in self.winding:
            return self._of_part(MOTOR_ONLY)
        if row not in _READS:
            return set(self.names)
        if not self.plain:
            return self._of_part(WIRES_ONLY)
        odd = {n for n, part in zip(self.names, self.part, strict=True) if part == BOTH}
        return set(_READS[row]) | (odd - {"motor_current"} if row != "motor_speed" else odd)

    def _of_part(self, part: int) -> set[str]:
        return {n for n, of in zip(self.names, self.part, strict=True) if of in (BOTH, part)}


def shape(
    states: Layout, channels: Layout, stage_of: Callable[[str], str], effects: tuple[Effect, ...]
) -> Shape:
    """Place all `states`, those of `effects` included."""
    found = Arrow()
    stages = {term.writes[0]: stage_of(term.writes[0]) for each in effects for term in each.terms}
    homes = _HOMES | _homes(effects, stages)
    for slot in sorted(states.slots, key=lambda slot: slot.name not in _OF_WIRES):
        places = range(states[slot.name].start, states[slot.name].stop)
        home = homes.get(slot.name, "fingers" if slot.axis in PER_FINGER else "")
        if slot.axis in PER_FINGER and home == "fingers":
            share = PER_FINGER[slot.axis]
            for k in places:
                found.own[(k - places.start) // share].append(k)  # angles, speeds, effects'
            found.kinds += [(slot.name, link) for link in range(share)]
            continue
        names = [f"{slot.name}{n}" if slot.axis else slot.name for n in range(slot.size)]
        found.core += places
        found.names += names
        found.winding += names if home == "motor" else []
        found.part += [_READER.get(home, BOTH)] * slot.size
        found.cart += [0, 1] if slot.name in _OF_WIRES else [-1] * slot.size
    for effect in effects:
        for term in effect.terms:
            _join(found, effect, term, states, channels, stages[term.writes[0]])
    found.trailing = set(_trailing(effects))
    if found.broken:
        return Shape((arrow,), {}, "", found.broken)
    found.seen.sort()
    pattern, takes = found.pattern()
    written = elimination.text(pattern, takes, found.core, found.seen)
    written += "\n\n" + elimination.fingers(found.own_pattern())
    fingers = finger_slopes if found.plain_fingers else finger_differences
    core = core_slopes if found.plain_core else core_differences
    return Shape((fingers, core, arrow), found.constants(), written, found.broken)


def _homes(effects: tuple[Effect, ...], stages: dict[str, str]) -> dict[str, str]:
    """The part whose stages set the rates of each effect's states, by full name."""
    return {
        f"{effect.name}.{name}": PARTS[stages[term.writes[0]]]
        for effect in effects
        for term in effect.terms
        for name in term.states
    }


def _trailing(effects: tuple[Effect, ...]) -> Iterator[str]:
    """Full names of states that only their own term reads, which only adds to what is told."""
    terms = [(effect, term) for effect in effects for term in effect.terms]
    for effect, term in terms:
        if set(term.writes) <= set(_TOLD) and len(term.states) == 1:
            others = {name for _, each in terms if each is not term for name in each.arguments}
            if not others & {*term.states, *term.writes}:
                yield f"{effect.name}.{term.states[0]}"


def _join(
    found: Arrow, effect: Effect, term: Term, states: Layout, channels: Layout, stage: str
) -> None:
    """Note what one kernel of an effect adds to the structure."""
    part, axis = PARTS[stage], channels.slot(term.writes[0]).axis
    own = {each.name for each in effect.parameters}
    arguments = [name for name in term.arguments if name not in own]
    reads = tuple(_read_states(effect, arguments, states))
    arrays = [channels.slot(n) for n in arguments if n in channels and channels.slot(n).axis]
    whys = [_reads_state(found, slot, states, axis, part, term) for slot in reads]
    whys += [_reads_channel(slot, axis, part) for slot in arrays]
    whys += [f"reads all of {name}" for name in arguments if name in _WHOLE]
    whys += [
        f"has a state {name} of no finger"
        for name in term.states
        if part == "fingers" and states.slot(f"{effect.name}.{name}").axis not in PER_FINGER
    ]
    found.broken = found.broken or next((f"{effect.name} {why}" for why in whys if why), "")
    found.plain_fingers &= part != "fingers"
    plain = part == "fingers" or _is_plain(term, stage, reads, bool(arrays))
    found.plain_core &= plain and "t" not in arguments  # core_slopes.py takes no stage's time
    turned = "torque_constant" in term.writes  # what the winding's stage hands to the gear's
    found.timed |= (part != "motor" or turned) and "t" in arguments
    if turned and set(arguments) & set(_OF_DRIVE):
        found.part = [BOTH if part == MOTOR_ONLY else part for part in found.part]
    names = {slot.name for slot in arrays}
    if part == "fingers":
        own_states = {f"{effect.name}.{name}" for name in term.states}
        found.apart |= own_states if PER_FINGER.get(axis) == 2 and not names & _SHARED else set()
    found.held &= part != "fingers" or not names & {"tendon_tension", "joint_torque"}
    if part == "wires":
        usual = set(_USUAL.get((stage, axis), ()))
        found.carted &= not term.states and names <= usual
        found.alike &= not names
        read = names if stage == "gear" else names | {slot.name for slot in reads}
        found.plain &= not term.states and read <= usual


def _is_plain(term: Term, stage: str, reads: tuple[Slot, ...], arrays: bool) -> bool:
    """Tell whether core_slopes.py has all that one kernel adds to motor or wires."""
    if arrays or term.states or "t" in term.arguments:
        return False
    if stage == "gear":
        return all(slot.name in _ROTOR for slot in reads)
    return set(term.writes) <= set(_CONSTANTS) and not reads


def _read_states(effect: Effect, arguments: list[str], states: Layout) -> Iterator[Slot]:
    for name in arguments:
        for full in (f"{effect.name}.{name}", name):
            if full in states:
                yield states.slot(full)
                break


def _reads_state(found: Arrow, slot: Slot, states: Layout, axis: str, part: str, term: Term) -> str:
    """Note who reads a state; say what the arrow has no place for."""
    first = states[slot.name].start
    if first not in found.core:
        return "" if part == "fingers" and _own(slot, axis) else f"reads all of {slot.name}"
    for n in range(found.core.index(first), found.core.index(first) + slot.size):
        if part == "fingers" and n not in found.seen:
            found.seen.append(n)
        reader = _READER.get(part, found.part[n])
        if found.part[n] != reader or "torque_constant" in term.writes:
            found.part[n] = BOTH
    return ""


def _reads_channel(slot: Slot, axis: str, part: str) -> str:
    if part == "wires":
        return "" if slot.name in (*_TAKEN_UP, *_FROM_WIRES) else f"reads {slot.name} in the wires"
    if slot.name in _OF_CART:
        return f"reads {slot.name} in the fingers"
    return "" if _own(slot, axis) else f"reads all of {slot.name}"


def _own(slot: Slot, axis: str) -> bool:
    """Tell whether a kernel called along `axis` gets its own finger's element of a slot."""
    if axis not in PER_FINGER or slot.axis not in PER_FINGER:
        return False
    return slot.axis == "finger" or PER_FINGER[slot.axis] == PER_FINGER[axis]
