"""The effects: meaning, equation, source, parameters, channels."""

from hannes.core.effect import Effect
from hannes.plants.part_fault import PartFault
from hannes.plants.protocol import PLANTS, find_plant
from hannes.simulation.catalogue import descriptions, effects, laws
from hannes.simulation.hand.anatomy import FINGERS
from hannes.simulation.hand.hand_file import own_catalogue
from tools.reference.markdown import code, number, table

HEAD = """# Effects

`hannes effects` lists these.
`hannes effects NAME` shows one, with what it is easily confused with.
A parameter with a value under "vanishes at" is an amplitude.
With all its amplitudes there, an effect leaves the model unchanged to the bit.
It is not compiled then.
"""

GENERIC = """# Generic disturbances

A diagnosis fits these where it can name nothing, and `hannes diagnose --describe` writes the
likeliest into `hand.toml`.
They follow recordings by a law of free shape, and claim no cause.
"""

SYMBOLS = {  # of the equations, as on the page of physics
    "th, w, i": "angle, speed and current of the motor",
    "N, r_p": "gear ratio; radius of the pulley that winds the leader wire",
    "tl": "load of the wire at the motor side",
    "T_dry, w_s, f": "dry friction of motor and gear, the width of its tanh, viscous friction",
    "R, k_t": "winding resistance and torque constant",
    "V_0, V_bus": "bus voltage without and with load",
    "T_L": "tension of the leader wire",
    "v, v_b": "speed of a cart, and that of its breakaway friction",
    "k_p, k_d, i_max": "gains of the position loop in the firmware, and its limit of the current",
    "g": "gravity in the frame of the hand",
    "q": "angle of a joint",
    "s_L, x_A, x_B, l_thumb": "stretch of the leader wire; carts; wire that the thumb takes up",
    "k, x, F, beta": "stiffness, depth, force and damping of a contact",
    "m": "what is logged; of a floating object its mass",
    "z": "a bristle between -1 and 1",
}


def page() -> str:
    """Text of the page."""
    shared = effects()
    symbols = table(("symbol", "is"), [(code(name), said) for name, said in SYMBOLS.items()])
    parts = [f"{HEAD}\n{symbols}\n", *(_effect(each) for each in shared.values())]
    for name in PLANTS:
        own = [each for key, each in own_catalogue(find_plant(name)).items() if key not in shared]
        if own:
            parts.append(f'# Effects of the plant "{name}" alone\n')
            parts += [_effect(each) for each in own if not isinstance(each, PartFault)]
            parts += _faults([each for each in own if isinstance(each, PartFault)])
    parts.append("# Laws\n\nThese are never tried by a diagnosis.\n")
    parts += [_effect(each) for each in laws().values()]
    parts.append(GENERIC)
    parts += [_effect(each.effect) for each in descriptions().values()]
    return "\n".join(parts)


def _faults(faults: list[PartFault]) -> list[str]:
    """Those of the first finger, and what the others are called."""
    shown = [each for each in faults if each.name.startswith(FINGERS[0])]
    settings = [each for each in faults if not each.kind]
    others = ", ".join(code(each) for each in FINGERS[1:])
    note = f"A fault of one part moves values of that part. The same are there for {others}.\n"
    parts = [note, *map(_effect, shown)] if shown else []
    if settings:
        parts += ["A setting that is other than stated moves values too.\n"]
    return [*parts, *map(_effect, settings)]


def _acts(each: Effect) -> str:
    if isinstance(each, PartFault):
        moved = {name: None for moves in each.moves.values() for name in moves}
        return f"Moves {', '.join(map(code, moved))}."
    writes = (code(name) for term in each.terms for name in term.writes)
    return f"Adds to {', '.join(writes)}."


def _effect(each: Effect) -> str:
    rows = [
        (
            code(each.full_name(own.name)),
            own.unit,
            own.doc,
            " to ".join(number(end) for end in own.bounds),
            "by earlier runs" if own.earlier else number(own.value),
            "" if own.off is None else number(own.off),
        )
        for own in each.parameters
    ]
    columns = ("parameter", "unit", "meaning", "bounds", "default", "vanishes at")
    return (
        f"## {each.name}\n\n{each.meaning}\n\n{code(each.equation)}\n\n"
        f"Source: {each.source}.\n{_acts(each)}\n\n{table(columns, rows)}\n"
    )
