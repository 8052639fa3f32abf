"""Whether an object stands clear of the open hand, as every grasp must begin."""

import numpy as np

from hannes._jit import plain
from hannes.anatomy import FINGERS
from hannes.contact import section
from hannes.dynamics import finger
from hannes.errors import BadInput
from hannes.experiment import Experiment
from hannes.hand import EQUATIONS, Hand

DEEPEST = 1e-6  # m of overlap that rounding may leave
PLACES = 200  # points tried along a phalanx; a circle is missed by less than 1 um
PHALANGES = ("second", "third")


def overlaps(hand: Hand, experiment: Experiment) -> dict[str, float]:
    """Depth [m] of each moving phalanx of the open hand in the object, negative where clear.

    Keys are such as "second phalanx of the index finger"; empty where there is no object.
    """
    if experiment.object is None:
        return {}
    posed = hand.with_values(experiment.overrides())
    packed, layout = posed.vector(experiment.shape, ()), EQUATIONS.parameters
    p = {slot.name: packed[layout[slot.name]] for slot in layout.slots}
    return {
        f"{PHALANGES[link]} phalanx of the {name}{'' if name == 'thumb' else ' finger'}": _depth(
            p, f, link
        )
        for f, name in enumerate(FINGERS)
        for link in range(2)
        if p["reach"][2 * f] > 0.0
    }


def require_clear(hand: Hand, experiment: Experiment, where: str) -> None:
    """Raise BadInput where the object intersects the open hand; `where` names the file."""
    inside = {name: x for name, x in overlaps(hand, experiment).items() if x > DEEPEST}
    if not inside:
        return
    name, depth = max(inside.items(), key=lambda item: item[1])
    others = f" ({len(inside) - 1} more overlap too)" if len(inside) > 1 else ""
    raise BadInput(
        f"{where}: the object intersects the open hand: the {name} lies {1e3 * depth:.1f} mm "
        f"inside it{others}; move the object along y or x, or make it smaller"
    )


def _depth(p: dict[str, np.ndarray], f: int, link: int) -> float:
    lengths = p["link_length"][2 * f : 2 * f + 2]
    rest = p["rest"][2 * f : 2 * f + 2]
    x, y, along_x, along_y = plain(finger.link_frame)(link, *rest, lengths[0])
    x -= p["object_x"][0] - p["mount_x"][f]
    y -= p["facing"][f] * (p["object_y"][0] - p["mount_y"][f])
    half = p["section_half_x"][f], p["section_half_y"][f]
    gap = min(
        plain(section.signed_distance)(x + place * along_x, y + place * along_y, *half)[0]
        for place in np.linspace(0.0, lengths[link], PLACES)
    )
    return float(p["reach"][2 * f + link] - gap)
