"""What the paper publishes: numbers, never curves. Every comparison reads them here.

"A Multi-Body Model of an upper-limb prosthesis for grip force estimation and related object
interaction application"; SI units unless said.
"""

from dataclasses import dataclass

TITLE = (
    "A Multi-Body Model of an upper-limb prosthesis for grip force estimation and related object "
    "interaction application"
)


@dataclass(frozen=True)
class Figure2:
    """One column of Table II: the value of the real hand and of the paper's model."""

    name: str
    symbol: str
    meaning: str
    unit: str
    hand: float
    model: float


TABLE_2 = (
    Figure2("I_avgc", "I avg,c", "mean current while closing freely", "A", 0.329, 0.329),
    Figure2("I_avgo", "I avg,o", "mean current while opening freely", "A", 0.238, 0.241),
    Figure2("I_max", "I max", "peak current", "A", 2.477, 2.555),
    Figure2("I_sc", "I s,c", "rising slope of the current", "A/s", 6.521, 5.508),
    Figure2("I_so", "I s,o", "falling slope of the current", "A/s", -10.577, -6.749),
    Figure2("F_max", "F max", "peak grasp force (section III.C)", "N", 194.8, 174.9),
)


@dataclass(frozen=True)
class Friction:
    """One row of Table I, orders of magnitude; `scale` takes an SI value to the paper's unit."""

    place: str
    part: str
    symbol: str
    parameter: str
    magnitude: float
    unit: str
    scale: float = 1.0


_RPM = 60.0 / (2.0 * 3.141592653589793)

TABLE_1 = (
    Friction("MCP", "mcp", "T_bf", "breakaway_friction", 1e-2, "N m"),
    Friction("MCP", "mcp", "ω_bf", "breakaway_speed", 1e2, "rpm", _RPM),
    Friction("MCP", "mcp", "T_cf", "coulomb_friction", 1e-2, "N m"),
    Friction("MCP", "mcp", "f", "viscous_friction", 1e-3, "N m/(rad/s)"),
    Friction("PIP", "pip", "T_bf", "breakaway_friction", 1e-2, "N m"),
    Friction("PIP", "pip", "ω_bf", "breakaway_speed", 1e2, "rpm", _RPM),
    Friction("PIP", "pip", "T_cf", "coulomb_friction", 1e-3, "N m"),
    Friction("PIP", "pip", "f", "viscous_friction", 1e-3, "N m/(rad/s)"),
    Friction("Linear guide", "cart", "F_bf", "breakaway_friction", 1e-2, "N"),
    Friction("Linear guide", "cart", "v_bf", "breakaway_speed", 10.0, "mm/s", 1e3),
    Friction("Linear guide", "cart", "F_cf", "coulomb_friction", 1e-2, "N"),
    Friction("Linear guide", "cart", "f", "viscous_friction", 1e-3, "N/(mm/s)", 1e-3),
)

VOID_CURRENT = 0.25  # A, mean of four hands (section III.B)
VOID_SPREAD = 0.03  # A, their standard deviation
VOID_MODEL = 0.26  # A, the paper's model
CONTACT = 0.3  # s, end of the void closing phase (section II.C)
PHASES = (0.3, 0.7, 1.0)  # s: void closing, grasp, void opening end

# Table III: F1 of each object [%].
TABLE_3 = {
    "Hand dynamometer": 97.3, "Aluminium block": 89.3, "Ultem block": 92.3, "Crutch handle": 94.9,
    "Blue ball": 100.0, "Green ball": 99.3, "Banana plush": 88.6, "Sponge": 99.0,
    "Orange plush": 69.5, "Grape plush": 80.53,
}  # fmt: skip
TABLE_3_AVERAGE = 91.07
TABLE_3_BY_CLASS = {"rigid": (93.5, 3.4), "soft": (89.5, 12.5)}  # mean, standard deviation
