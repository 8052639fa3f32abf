"""The effects: meaning, equation, source, parameters, channels."""

from hannes.core.effect import Effect
from hannes.plants.protocol import PLANTS, find_plant
from hannes.simulation.catalogue import effects, laws_of_objects
from hannes.simulation.hand.hand_file import own_catalogue
from tools.reference.markdown import code, number, table

HEAD = """# Effects

`hannes effects` lists these.
`hannes effects NAME` shows one, with what it is easily confused with.
A parameter with a value under "vanishes at" is an amplitude.
With all its amplitudes there, an effect leaves the model unchanged to the bit.
It is not compiled then.
"""


def page() -> str:
    """Text of the page."""
    shared = effects()
    parts = [HEAD, *(_effect(each) for each in shared.values())]
    for name in PLANTS:
        own = [each for key, each in own_catalogue(find_plant(name)).items() if key not in shared]
        if own:
            parts.append(f'# Effects of the plant "{name}" alone\n')
            parts += [_effect(each) for each in own]
    laws = [each for key, each in laws_of_objects().items() if key not in shared]
    if laws:
        parts.append("# Laws\n\nThese are never tried by a diagnosis.\n")
        parts += [_effect(each) for each in laws]
    return "\n".join(parts)


def _effect(each: Effect) -> str:
    writes = ", ".join(code(name) for term in each.terms for name in term.writes)
    rows = [
        (
            code(each.full_name(own.name)),
            own.unit,
            own.doc,
            " to ".join(number(end) for end in own.bounds),
            number(own.value),
            "" if own.off is None else number(own.off),
        )
        for own in each.parameters
    ]
    columns = ("parameter", "unit", "meaning", "bounds", "default", "vanishes at")
    return (
        f"## {each.name}\n\n{each.meaning}\n\n{code(each.equation)}\n\n"
        f"Source: {each.source}.\nAdds to {writes}.\n\n{table(columns, rows)}\n"
    )
