"""Where each phalanx touches the object and which way it is pushed, for the arrows."""

import numpy as np

from hannes.contact.leaning import nearest_place
from hannes.contact.section import contact_place, signed_distance
from hannes.core.kernels.jit import plain
from hannes.simulation.hand.anatomy import FINGERS
from hannes.simulation.hand.hand import Hand
from hannes.simulation.hand.model import EQUATIONS


def touches(
    hand: Hand, shape: str, points: np.ndarray, pose: np.ndarray, forces: np.ndarray
) -> np.ndarray:
    """Contact point [m] and normal of each phalanx that is pressed, shape (n, 10, 4).

    In the finger's plane, seen from MCP. points: of `finger_points`; pose: of `object_motion`;
    forces: normal forces [N], shape (n, 10). Zero where a phalanx touches nothing.
    """
    packed, layout = hand.vector(shape), EQUATIONS.parameters
    p = {slot.name: packed[layout[slot.name]] for slot in layout.slots}
    found = np.zeros((len(points), 2 * len(FINGERS), 4))
    for phalanx in range(2 * len(FINGERS)):
        pressed = np.flatnonzero(forces[:, phalanx] > 0.0)
        if pressed.size:
            start, along, length = _link(points[pressed], phalanx)
            away = start - _centre(p, pose[pressed], phalanx)
            place, normal = _nearest(p, phalanx, away, along, length, pose[pressed, 2])
            axis = start + place[:, np.newaxis] * along
            radius = p["phalanx_radius"][phalanx]
            found[pressed, phalanx] = np.hstack([axis - radius * normal, normal])
    return found


def _link(points: np.ndarray, phalanx: int) -> tuple[np.ndarray, np.ndarray, float]:
    """Start [m], direction and length [m] of a phalanx."""
    pip, tip = points[:, phalanx // 2, :2], points[:, phalanx // 2, 2:]
    start, end = (pip, tip) if phalanx % 2 else (np.zeros_like(pip), pip)
    length = float(np.linalg.norm(end[0] - start[0]))
    return start, (end - start) / length, length


def _centre(p: dict[str, np.ndarray], pose: np.ndarray, phalanx: int) -> np.ndarray:
    """Centre of the object's section in the finger's plane [m], shape (n, 2)."""
    f = phalanx // 2
    cosine, sine = np.cos(pose[:, 2]), np.sin(pose[:, 2])
    aside_x, aside_y = p["section_aside_x"][f], p["section_aside_y"][f]
    x = pose[:, 0] - p["mount_x"][f] + cosine * aside_x - sine * aside_y
    y = pose[:, 1] - p["mount_y"][f] + sine * aside_x + cosine * aside_y
    return np.stack([x, p["facing"][f] * y], axis=1)


def _nearest(
    p: dict[str, np.ndarray],
    phalanx: int,
    away: np.ndarray,
    along: np.ndarray,
    length: float,
    turned: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """Place of nearest approach along the link [m] and outward normal there, as the model has it.

    away: start of the link from the section's centre [m].
    """
    f, flat = phalanx // 2, p["object_flat"][0]
    if flat == 0.0:
        place = np.clip(-np.einsum("nx,nx->n", away, along), 0.0, length)
        normal = away + place[:, np.newaxis] * along
        return place, normal / np.linalg.norm(normal, axis=1, keepdims=True)
    half = float(p["section_half_x"][f]), float(p["section_half_y"][f])
    rows = []
    for start, link, angle in zip(away, along, turned, strict=True):
        if flat == 2.0:
            radius = float(p["reach"][phalanx] - p["phalanx_radius"][phalanx])
            section = (*half, radius, *_frame(p, f, angle))
            place, _, *normal = plain(nearest_place)(*start, *link, length, section)
        else:
            place = plain(contact_place)(*start, *link, length, *half)
            _, *normal = plain(signed_distance)(*(start + place * link), *half)
        rows.append((place, *normal))
    table = np.array(rows)
    return table[:, 0], table[:, 1:]


def _frame(p: dict[str, np.ndarray], f: int, angle: float) -> tuple[float, float, float, float]:
    """The object's frame in a finger's plane, turned by `angle` [rad]; see `touch_leaning`."""
    cosine, sine, facing = np.cos(angle), np.sin(angle), float(p["facing"][f])
    xx, xy, yx, yy = (float(p[f"frame_{name}"][0]) for name in ("xx", "xy", "yx", "yy"))
    return (
        cosine * xx - sine * yx,
        cosine * xy - sine * yy,
        facing * (sine * xx + cosine * yx),
        facing * (sine * xy + cosine * yy),
    )
