"""Derivatives of what effects add to joints and contacts, as text for finger_blocks.py.

For kernels of one joint or phalanx that read its motion or its contact and their own states, and
for those of force sensors. With any other kernel in them, fingers are differenced.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from hannes.core.effect import Effect, Term
from hannes.simulation.compiler.autodiff.dead_code import without_dead_code
from hannes.simulation.compiler.autodiff.forward import Differentiation
from hannes.simulation.compiler.autodiff.values import Value
from hannes.simulation.compiler.expansion import Layouts
from hannes.simulation.hand.jacobian.drivetrain_block import WRITTEN

# By what a kernel of each stage may be differentiated, and under which name.
_OF_JOINT = {
    "joint_angle": "angle",
    "lane_angle": "angle",
    "joint_speed": "speed",
    "lane_speed": "speed",
}
_OF_PHALANX = {"penetration": "depth", "penetration_rate": "rate"}
_INPUTS = {
    "spring_torque": _OF_JOINT,
    "joint_friction": _OF_JOINT,
    "normal_force": _OF_PHALANX,
    "logged_force": {"logged_force": "logged"},
    "logged_sensor": {"logged_sensor": "logged"},
}
_PLACED = {"object_x", "object_y", "object_angle"}  # no derivatives where the object is fixed
_LOGGED = ("logged_force", "logged_sensor")


@dataclass(frozen=True)
class DifferentiatedTerm:
    """A kernel in the fingers, and the first row among a finger's states of each of its own."""

    effect: Effect
    term: Term
    rows: Mapping[str, int]

    @property
    def channel(self) -> str:
        """What it adds to."""
        return self.term.writes[0]

    @property
    def of_joint(self) -> bool:
        """Whether it adds to a joint's torque, not to a contact."""
        return _INPUTS.get(self.channel) is _OF_JOINT

    @property
    def pressed(self) -> bool:
        """Whether it adds to a phalanx' normal force."""
        return self.channel == "normal_force"

    @property
    def logged(self) -> bool:
        """Whether it adds to the reading of a force sensor."""
        return self.channel in _LOGGED


def fits(effect: Effect, term: Term, layouts: Layouts) -> bool:
    """Whether the terms of a kernel in the fingers are differentiated here."""
    inputs = _INPUTS.get(term.writes[0], {}) if len(term.writes) == 1 else {}
    own = {each.name for each in effect.parameters}
    states = {each.name: each.axis for each in effect.states}
    axis = layouts.c.slot(term.writes[0]).axis
    for name in term.arguments:
        if name in states:
            pair = {states[name], axis}
            if name not in term.states or not (len(pair) == 1 or pair == {"joint", "phalanx"}):
                return False
        elif name not in own and name not in inputs and name not in layouts.p and name != "t":
            return False
    if term.writes[0] in _LOGGED:
        return len(term.states) == 1
    return bool(inputs) or (set(term.writes) <= _PLACED and not term.states)


def text(
    terms: Sequence[DifferentiatedTerm], size: int, layouts: Layouts, names: Mapping[str, Any]
) -> str:
    """Functions `joint_effects` and `contact_effects`; `size`: of a finger's own states."""
    parts = (
        "def joint_effects(t, y, p, c, blocks):",
        '    """Torque of a joint by its own motion and states, these by each other."""',
        *[f"    blocks[2:4, 4:{size}] = 0.0", f"    blocks[4:{size}] = 0.0"] * (size > 4),
        *_of_joints(_Loop([each for each in terms if each.of_joint], layouts, names)),
        "",
        "",
        "def contact_effects(t, y, p, c, blocks):",
        '    """Normal forces by their rates and states; positive where contacts move a state."""',
        "    moves = 0.0",
        "    for k in range(p.rest.size):",
        "        c.pressing[k] = 0.0",
        *_loop(
            10,
            _of_phalanges(_Loop([each for each in terms if each.pressed], layouts, names), terms),
        ),
        *_loop(
            5, _of_sensors(_Loop([each for each in terms if each.logged], layouts, names), terms)
        ),
        "    return moves",
    )
    return layouts.expanded("\n".join(parts))


def _loop(count: int, lines: Sequence[str]) -> list[str]:
    if not lines:
        return []
    head = [f"    for k in range({count}):"]
    head += ["        f, link = k // 2, k % 2"] if count == 10 else []
    return head + ["        " + line for line in lines]


class _Loop:
    """Kernels in one loop over joints, phalanges or fingers, and their derivatives' lines."""

    def __init__(
        self, terms: Sequence[DifferentiatedTerm], layouts: Layouts, names: Mapping[str, Any]
    ) -> None:
        self.terms, self._layouts, self._found = terms, layouts, Differentiation({}, names, WRITTEN)
        self.lines = self._found.lines

    def present(self, part: DifferentiatedTerm) -> str:
        """Condition that the effect of a kernel does not vanish."""
        return self._layouts.present(part.effect)

    def differentiated(
        self, part: DifferentiatedTerm
    ) -> tuple[Mapping[str, str], dict[str, Mapping[str, str]]]:
        """Derivatives of what is added, and of the rate of each state."""
        axis, inputs = self._layouts.c.slot(part.channel).axis, _INPUTS[part.channel]
        columns = {**inputs, **{name: name for name in part.rows}}
        given = [
            Value(
                self._layouts.argument(name, part.effect, axis),
                {columns[name]: "1.0"} if name in columns else {},
            )
            for name in part.term.arguments
        ]
        result = self._found.kernel(part.effect.kernel_name(part.term), given)
        added, *rates = result if isinstance(result, tuple) else (result,)
        derivatives = {
            name: rate.derivatives for name, rate in zip(part.term.states, rates, strict=True)
        }
        return added.derivatives, derivatives


def _of_joints(loop: _Loop) -> list[str]:
    """A loop over the joints for each kernel, which runs where its effect is present."""
    found = []
    for part in loop.terms:
        lines = _loop(10, without_dead_code(_of_joint(loop, part))) or ["    pass"]
        found += [f"    if {loop.present(part)}:", *("    " + line for line in lines)]
    return found


def _of_joint(loop: _Loop, part: DifferentiatedTerm) -> list[str]:
    loop.lines.clear()
    added, rates = loop.differentiated(part)
    for by, slope in added.items():
        target = f"c.own_{by}_slope[k]" if by not in part.rows else ""
        loop.lines.append(f"{target or f'blocks[2 + link, {part.rows[by]} + link, f]'} -= {slope}")
    for state, derivatives in rates.items():
        for by, slope in derivatives.items():
            column = {"angle": 0, "speed": 2}.get(by, part.rows.get(by))
            loop.lines.append(f"blocks[{part.rows[state]} + link, {column} + link, f] = {slope}")
    return list(loop.lines)


def _of_phalanges(loop: _Loop, terms: Sequence[DifferentiatedTerm]) -> list[str]:
    logged = [each for each in terms if each.logged]
    if not logged and not loop.terms:
        return []
    loop.lines += [
        "pushes = 1.0 if c.normal_force[k] > 0.0 else 0.0",
        "faces = 1.0 if c.normal_x[k] > 0.0 else 0.0",
        "turned = soft_sign(c.slip_speed[k] / p.object_slip_speed)",
        "drag = p.object_friction * turned",
        "on_mcp = c.normal_arm_mcp[k] - drag * c.slip_arm_mcp[k]",
        "on_pip = c.normal_arm_pip[k] - drag * c.slip_arm_pip[k]",
        "on_sensor = faces * (c.normal_x[k] + drag * c.normal_y[k])",
    ]
    for each in loop.terms:
        before = len(loop.lines)
        _press(loop, each, logged)
        pressed = loop.lines[before:] or ["pass"]
        loop.lines[before:] = [f"if {loop.present(each)}:", *("    " + line for line in pressed)]
    loop.lines += [
        "ramp = smoothstep(c.penetration[k] / p.object_onset)",
        "rise = pushes * p.object_damping * ramp + c.pressing[k]",
        "slip = p.object_friction * c.normal_force[k] * (1.0 - turned * turned)",
        "slip *= faces * c.normal_y[k] / p.object_slip_speed",
    ] * bool(logged)
    for each in logged:
        row = next(iter(each.rows.values()))
        for column, joint in ((2, "mcp"), (3, "pip")):
            by = f"-rise * c.normal_arm_{joint}[k]"
            if each.channel == "logged_sensor":
                by += f" * on_sensor + slip * c.slip_arm_{joint}[k]"
            loop.lines.append(f"blocks[{row}, {column}, f] += {by}")
    return without_dead_code(loop.lines)


def _press(loop: _Loop, part: DifferentiatedTerm, logged: Sequence[DifferentiatedTerm]) -> None:
    """What one kernel adds to a normal force; by the depth finger_blocks.py differences it."""
    added, rates = loop.differentiated(part)
    for by, slope in added.items():
        if by == "rate":
            loop.lines.append(f"c.pressing[k] += pushes * {slope}")
        elif by in part.rows:
            place = f"{part.rows[by]} + link, f"
            loop.lines.append(f"blocks[2, {place}] += pushes * {slope} * on_mcp")
            loop.lines.append(f"blocks[3, {place}] += pushes * {slope} * on_pip")
            for each in logged:
                (row,) = each.rows.values()
                share = " * on_sensor" if each.channel == "logged_sensor" else ""
                loop.lines.append(f"blocks[{row}, {place}] += pushes * {slope}{share}")
    for state, derivatives in rates.items():
        at = f"{part.rows[state]} + link"
        for by, slope in derivatives.items():
            if by not in part.rows:
                loop.lines.append(f"moves += abs({slope})")
            if by == "rate":
                loop.lines.append(f"blocks[{at}, 2, f] = -{slope} * c.normal_arm_mcp[k]")
                loop.lines.append(f"blocks[{at}, 3, f] = -{slope} * c.normal_arm_pip[k]")
            elif by in part.rows:
                loop.lines.append(f"blocks[{at}, {part.rows[by]} + link, f] = {slope}")


def _of_sensors(loop: _Loop, terms: Sequence[DifferentiatedTerm]) -> list[str]:
    for each in loop.terms:
        before, columns = len(loop.lines), [2, 3, *_pressed(terms)]
        (state, row), (_, rates) = *each.rows.items(), loop.differentiated(each)
        places = [f"blocks[{row}, {column}, k]" for column in columns]
        own = f"blocks[{row}, {row}, k] = "
        loop.lines += [f"{place} *= {rates[state].get('logged', '0.0')}" for place in places]
        loop.lines.append(own + rates[state].get(state, "0.0"))
        still = [*(f"{place} = 0.0" for place in places), own + "0.0"]
        loop.lines[before:] = [
            f"if {loop.present(each)}:",
            *("    " + line for line in loop.lines[before:]),
            "else:",
            *("    " + line for line in still),
        ]
    return without_dead_code(loop.lines)


def _pressed(terms: Sequence[DifferentiatedTerm]) -> list[int]:
    """Rows of the states that normal forces depend on."""
    return [
        row + link
        for each in terms
        if each.pressed
        for row in each.rows.values()
        for link in (0, 1)
    ]


def touched(terms: Sequence[DifferentiatedTerm]) -> list[int]:
    """Rows of the states whose rates depend on where contacts lie."""
    return _pressed(terms) + [row for each in terms if each.logged for row in each.rows.values()]


def pattern(terms: Sequence[DifferentiatedTerm], size: int) -> list[list[bool]]:
    """Where the rates of a finger's own states may depend on these."""
    full = [[i == j for j in range(size)] for i in range(size)]
    full[0][2] = full[1][3] = True
    for i in (2, 3):
        full[i][:4] = [True] * 4
    for each in terms:
        for row in each.rows.values():
            _join(full, each, row, terms)
    return full


def _join(
    full: list[list[bool]],
    part: DifferentiatedTerm,
    row: int,
    all_terms: Sequence[DifferentiatedTerm],
) -> None:
    """Note what the rate of a state depends on, and what depends on it."""
    if part.logged:
        for column in (0, 1, 2, 3, *_pressed(all_terms)):
            full[row][column] = True
        return
    for link in (0, 1):
        full[2][row + link] = full[3][row + link] = True
        for column in (link, 2 + link) if part.of_joint else range(4):
            full[row + link][column] = True
        for other in part.rows.values():
            full[row + link][other + link] = True
