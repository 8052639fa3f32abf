"""The hand from motor to fingertip as a drawing, made of its own parameters and effects.

Names are those of `hannes hand --values`. Every part carries a title with its values and the
effects that join there, which a browser shows where it is pointed at.
"""

from collections.abc import Collection, Iterable, Sequence
from functools import cache
from html import escape
from itertools import pairwise
from typing import Any

from hannes.plants.hand.plant import HandPlant
from hannes.report import schematic_layout as at
from hannes.simulation.catalogue import effects
from hannes.simulation.hand.anatomy import FINGERS
from hannes.simulation.hand.hand import Hand

# Under one class, for a page's other drawings have text and classes of their own.
STYLE = (
    ".schematic text{font:13px 'DejaVu Sans',Verdana,sans-serif;fill:#1a1a1a}"
    ".schematic text.small{font-size:11px;fill:#555}"
    ".schematic .part{stroke:#1a1a1a;stroke-width:1.5;fill:#e8ecf0}"
    ".schematic .spring{fill:none;stroke:#1a1a1a;stroke-width:1.3}"
    ".schematic .wire{fill:none;stroke:#0072B2;stroke-width:2.5}"
    ".schematic .follower .wire{stroke:#009E73;stroke-dasharray:9 2}"
    ".schematic .hidden{fill:none;stroke:transparent;stroke-width:14}"
    ".schematic .marked .part,.schematic .marked .wire{stroke:#D55E00;stroke-width:4}"
    ".schematic .marked text{fill:#a83c00;font-weight:700}"
    ".schematic g:hover>.part,.schematic g:focus>.part{fill:#ffe9b0}"
    ".schematic g:hover>.wire,.schematic g:focus>.wire{stroke-width:5}"
    ".schematic g:focus{outline:none}"
)


def schematic(hand: Hand | None = None, marked: Sequence[str] = ()) -> str:
    """The drawing as an SVG that stands alone; parts at which `marked` effects sit stand out."""
    hand = hand or Hand()
    known = {**effects(), **HandPlant().catalogue}
    ringed = {part for each in marked if each in known for part in at.parts_of(known[each])}
    body = [*_controller(hand, ringed), *_guides()]
    body += [line for cart in at.CARTS for line in _cart(hand, cart, ringed)]
    body += _wires(hand, ringed)
    body += [line for finger in FINGERS for line in _finger(hand, finger, ringed)]
    body += _object(hand, ringed)
    label = (
        "The hand: motor and gear wind the leader wire, which pulls two carts and the thumb; "
        "each cart pulls two fingers by a follower wire"
    )
    if ringed:
        label += f". Marked: {', '.join(sorted(ringed))}"
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {at.WIDTH} {at.HEIGHT}" '
        f'role="img" aria-label="{label}">\n<style>{STYLE}</style>\n<g class="schematic">\n'
        + "\n".join(body)
        + "\n</g>\n</svg>\n"
    )


def _group(hand: Hand, part: str, ringed: Collection[str], inside: Iterable[str]) -> list[str]:
    """One part that can be pointed at: its title holds its values and effects."""
    kinds = f"{part} marked" if _rung(part, ringed) else part
    title = escape(described(hand, part))
    return [f'<g class="{kinds}" data-part="{part}" tabindex="0"><title>{title}</title>', *inside,
            "</g>"]  # fmt: skip


def _rung(part: str, ringed: Collection[str]) -> bool:
    return part in ringed or (part in ("mcp", "pip") and "joint" in ringed)


def described(hand: Hand, part: str) -> str:
    """Values of a part with their units, and the effects that join there."""
    lines = [part]
    for name, each in hand.parameters.declared.items():
        like_all = each.shared and hand.parameters[name] == each.value
        if name.split(".")[0] in at.PARAMETERS[part] and not like_all:
            unit = "" if each.unit == "1" else f" {each.unit}"
            lines.append(f"{name} = {hand.parameters[name]:.4g}{unit} ({each.doc})")
    place = "joint" if part in ("mcp", "pip") else part
    joining = _joining().get(place, ())
    if joining:
        lines.append(f"effects here: {', '.join(joining)}")
    return "\n".join(lines)


@cache
def _joining() -> dict[str, list[str]]:
    """Effects of the catalogue by the part where they sit."""
    found: dict[str, list[str]] = {}
    for name, effect in effects().items():
        for part in at.parts_of(effect):
            found.setdefault(part, []).append(name)
    return found


def _text(x: float, y: float, words: str, small: bool = False, anchor: str = "middle") -> str:
    kind = ' class="small"' if small else ""
    return f'<text x="{x:g}" y="{y:g}" text-anchor="{anchor}"{kind}>{escape(words)}</text>'


def _box(x: float, y: float, width: float, height: float) -> str:
    return f'<rect class="part" x="{x:g}" y="{y:g}" width="{width:g}" height="{height:g}" rx="6"/>'


def _circle(x: float, y: float, radius: float) -> str:
    return f'<circle class="part" cx="{x:g}" cy="{y:g}" r="{radius:g}"/>'


def _line(points: Iterable[Sequence[Any]], kind: str) -> str:
    text = " ".join(f"{point[0]:g},{point[1]:g}" for point in points)
    return f'<polyline class="{kind}" points="{text}"/>'


def _controller(hand: Hand, ringed: Collection[str]) -> list[str]:
    """Controller, motor and gear with its pulley: the column at the left."""
    x, y = at.MOTOR, at.CARTS["a"]
    blocks = _group(hand, "controller", ringed,
                    [_box(8, 196, 104, 40), _text(60, 221, "controller")])  # fmt: skip
    blocks += [_line([(x, 196), (x, 178)], "part")]
    blocks += _group(hand, "motor", ringed, [_box(18, 138, 84, 40), _text(x, 163, "motor")])
    words = f"gear {hand.parameters['gear.ratio']:g}:1"
    blocks += _group(hand, "gear", ringed,
                     [_circle(x, y, at.WHEEL), _line([(x, y + at.WHEEL), (x, 138)], "part"),
                      _text(x, 66, words)])  # fmt: skip
    return blocks


def _wires(hand: Hand, ringed: Collection[str]) -> list[str]:
    route = at.leader()
    inside = [_line(route, "wire"), _line(route, "hidden"), _text(205, 186, "leader")]
    lines = _group(hand, "leader", ringed, inside)
    for cart in at.CARTS:
        route = at.follower(cart)
        inside = [_line(route, "wire"), _line(route, "hidden")]
        inside += [_text(404, at.CARTS[cart] + 5, "follower")]
        lines += _group(hand, "follower", ringed, inside)
    return lines


def _guides() -> list[str]:
    """Pulleys that stand."""
    circles = [_circle(x, y, at.SMALL - 2) for x, y in at.guides()]
    return ["<g><title>fixed pulleys: the model has no friction there</title>", *circles, "</g>"]


def _cart(hand: Hand, cart: str, ringed: Collection[str]) -> list[str]:
    x, y, r = at.CART, at.CARTS[cart], at.WHEEL
    inside = [
        _line([(x - 80, y + 42), (x + 80, y + 42)], "part"),
        _box(x - 56, y - 30, 112, 64),
        _circle(x - 32, y, r - 2),
        _circle(x + 32, y, r - 2),
        _text(x, y + 60, f"cart {cart.upper()}"),
    ]
    return _group(hand, "cart", ringed, inside)


def _finger(hand: Hand, finger: str, ringed: Collection[str]) -> list[str]:
    """Three phalanges in a row, joints as circles of their moment arms, spring and wire."""
    values, y, x = hand.parameters, at.ROWS[finger], float(at.FINGER)
    ends, wire = [x], [(x, y + at.flexor())]
    for link in ("first", "second", "third"):
        ends.append(ends[-1] + at.SCALE * values[f"{finger}.{link}_length"])
    links = [_box(a, y - 9, b - a, 18) for a, b in pairwise(ends)]
    lines = _group(
        hand, finger, ringed, [*links, _text(ends[-1] + 8, y + 5, finger, anchor="start")]
    )
    for joint, place in zip(("mcp", "pip"), ends[1:3], strict=True):
        arm = at.SCALE * values[f"{joint}.moment_arm"]
        wire.append((place, y + arm))
        inside = [_circle(place, y, arm), _spring(place, y)]
        if finger == "index":
            inside.append(_text(place, y - 26, joint, small=True))
        lines += _group(hand, joint, ringed, inside)
    wire.append((0.5 * (ends[2] + ends[3]), y + 9))
    name = "leader" if finger == "thumb" else "follower"
    return [*lines, *_group(hand, name, ringed, [_line(wire, "wire")])]


def _spring(x: float, y: float) -> str:
    """The re-opening spring: a zigzag over the joint."""
    points = [(x - 20 + 5 * k, y - 13 - (5 if k % 2 else 0)) for k in range(9)]
    return _line(points, "spring")


def _object(hand: Hand, ringed: Collection[str]) -> list[str]:
    x, y = 742, 353
    inside = [_circle(x, y, 17), _text(x + 24, y + 5, "object", anchor="start")]
    return _group(hand, "object", ringed, inside)
