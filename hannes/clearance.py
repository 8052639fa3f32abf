"""Whether an object stands clear of the open hand, as every grasp must begin."""

import numpy as np

from hannes._jit import plain
from hannes.anatomy import FINGERS
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
    depths = _depths(p)
    return {
        f"{PHALANGES[link]} phalanx of the {name}{'' if name == 'thumb' else ' finger'}": float(
            depths[2 * f + link]
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


def _depths(p: dict[str, np.ndarray]) -> np.ndarray:
    """Depth [m] of every phalanx of the open hand, shape (10,)."""
    lengths, count = p["link_length"], 2 * len(FINGERS)
    start = np.array(
        [
            plain(finger.link_frame)(
                k % 2, *p["rest"][k - k % 2 : k - k % 2 + 2], lengths[k - k % 2]
            )
            for k in range(count)
        ]
    )
    f = np.arange(count) // 2
    x = start[:, 0] - (p["object_x"] - p["mount_x"])[f]
    y = start[:, 1] - (p["facing"] * (p["object_y"] - p["mount_y"]))[f]
    places = np.linspace(0.0, 1.0, PLACES) * lengths[:count, np.newaxis]
    half_x, half_y = p["section_half_x"][f], p["section_half_y"][f]
    over_x = np.abs(x[:, np.newaxis] + places * start[:, 2:3]) - half_x[:, np.newaxis]
    over_y = np.abs(y[:, np.newaxis] + places * start[:, 3:4]) - half_y[:, np.newaxis]
    outside = np.hypot(np.maximum(over_x, 0.0), np.maximum(over_y, 0.0))
    gap = outside + np.minimum(np.maximum(over_x, over_y), 0.0)
    return p["reach"][:count] - gap.min(axis=1)
