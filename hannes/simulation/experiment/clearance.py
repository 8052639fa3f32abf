"""Whether an object stands clear of the open hand, as every grasp must begin."""

import numpy as np

from hannes.contact.leaning import ARCH
from hannes.core.errors import BadInput
from hannes.core.kernels.jit import plain
from hannes.dynamics import finger
from hannes.simulation.experiment.experiment import Experiment
from hannes.simulation.hand.anatomy import FINGERS
from hannes.simulation.hand.hand import Hand
from hannes.simulation.hand.model import EQUATIONS

DEEPEST = 1e-6  # m of overlap that rounding may leave
PLACES = 200  # points tried along a phalanx; a circle is missed by less than 1 um
NORMALS = 1441  # tried about an object that leans; a quarter of a degree misses 0.1 um
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
    depths = _leaning(p) if p["object_flat"][0] == 2.0 else _depths(p)
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


def _links(p: dict[str, np.ndarray]) -> np.ndarray:
    """Start from the object's centre [m] and direction of every phalanx of the open hand.

    Shape (10, 4), each in its finger's plane.
    """
    lengths, count = p["link_length"], 2 * len(FINGERS)
    links = np.array(
        [
            plain(finger.link_frame)(
                k % 2, *p["rest"][k - k % 2 : k - k % 2 + 2], lengths[k - k % 2]
            )
            for k in range(count)
        ]
    )
    f = np.arange(count) // 2
    links[:, 0] -= (p["object_x"] - p["mount_x"])[f]
    links[:, 1] -= (p["facing"] * (p["object_y"] - p["mount_y"]))[f]
    return links


def _leaning(p: dict[str, np.ndarray]) -> np.ndarray:
    """Depth [m] of every phalanx of the open hand in an object that leans, shape (10,).

    Two convex shapes are as far apart as the tangents, with one normal, that keep them apart best:
    the link's own, or nearly one of many.
    """
    links, f = _links(p), np.arange(2 * len(FINGERS)) // 2
    facing, lengths, radius = p["facing"][f], p["link_length"][: f.size], p["phalanx_radius"]
    start = links[:, :2] - np.stack([p["section_aside_x"], p["facing"] * p["section_aside_y"]]).T[f]
    own = np.arctan2(links[:, 3], links[:, 2])[:, np.newaxis] + (np.pi / 2.0, -np.pi / 2.0)
    others = np.broadcast_to(np.linspace(0.0, 2.0 * np.pi, NORMALS), (f.size, NORMALS))
    angles = np.hstack([own, others])
    normals = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    ends = start, start + lengths[:, np.newaxis] * links[:, 2:]
    nearer = np.minimum(*(np.einsum("knx,kx->kn", normals, end) for end in ends))
    across = facing[:, np.newaxis] * normals[..., 1]
    u = p["frame_xx"] * normals[..., 0] + p["frame_yx"] * across
    v = p["frame_xy"] * normals[..., 0] + p["frame_yy"] * across
    half_x, half_y, round_off = (
        each[:, np.newaxis]
        for each in (
            p["section_half_x"][f],
            p["section_half_y"][f],
            (p["reach"] - radius)[: f.size],
        )
    )
    tangent = half_x * np.hypot(u, ARCH) + half_y * np.hypot(v, ARCH) + round_off * np.hypot(u, v)
    return radius[: f.size] - (nearer - tangent).max(axis=1)


def _depths(p: dict[str, np.ndarray]) -> np.ndarray:
    """Depth [m] of every phalanx of the open hand, shape (10,)."""
    start, lengths, count = _links(p), p["link_length"], 2 * len(FINGERS)
    f, (x, y) = np.arange(count) // 2, start[:, :2].T
    places = np.linspace(0.0, 1.0, PLACES) * lengths[:count, np.newaxis]
    half_x, half_y = p["section_half_x"][f], p["section_half_y"][f]
    over_x = np.abs(x[:, np.newaxis] + places * start[:, 2:3]) - half_x[:, np.newaxis]
    over_y = np.abs(y[:, np.newaxis] + places * start[:, 3:4]) - half_y[:, np.newaxis]
    outside = np.hypot(np.maximum(over_x, 0.0), np.maximum(over_y, 0.0))
    gap = outside + np.minimum(np.maximum(over_x, over_y), 0.0)
    return p["reach"][:count] - gap.min(axis=1)
