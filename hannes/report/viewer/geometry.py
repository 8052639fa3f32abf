"""Where the parts of a hand are, from its joint angles: points in each finger's plane [m]."""

from dataclasses import dataclass

import numpy as np

from hannes.contact.shapes import frame, sections
from hannes.core.kernels.jit import plain
from hannes.simulation.hand.anatomy import FINGERS
from hannes.simulation.hand.hand import Hand

CORNER = 12  # points along each rounded corner of an outline
ACROSS = 0.06  # m, half length of a cylinder or prism as drawn


@dataclass(frozen=True)
class Outlines:
    """Closed outlines of an object [m] about its centre, each in a plane z = const of the hand.

    `planes`: z [m] of each, from the hand frame's origin; `points` has the shape (m, n, 2).
    """

    planes: np.ndarray
    points: np.ndarray


def finger_points(hand: Hand, angles: np.ndarray) -> np.ndarray:
    """PIP joint and tip of each finger in its plane, seen from MCP [m], shape (n, 5, 4).

    angles: joint angles [rad], shape (n, 10), in the order of the state `joint_angle`. A link at
    angle q points along (cos q, -sin q).
    """
    lengths = np.array([_lengths(hand, finger) for finger in FINGERS])
    first, second = angles[:, 0::2], angles[:, 0::2] + angles[:, 1::2]
    pip = lengths[:, 0, np.newaxis] * np.array([np.cos(first), -np.sin(first)]).transpose(1, 2, 0)
    link = lengths[:, 1, np.newaxis] * np.array([np.cos(second), -np.sin(second)]).transpose(
        1, 2, 0
    )
    return np.concatenate([pip, pip + link], axis=2)


def _lengths(hand: Hand, finger: str) -> tuple[float, float]:
    values = hand.parameters
    return values[f"{finger}.second_length"], values[f"{finger}.third_length"]


def object_motion(hand: Hand, states: np.ndarray) -> np.ndarray:
    """Centre of the object in the hand frame [m] and its turn [rad] over time, shape (n, 3)."""
    values, layout = hand.parameters, hand.compiled().states
    pose = np.zeros((len(states), 3))
    pose[:, :2] = values["object.x"], values["object.y"]
    for effect in hand.present_effects():
        known = {each.name: values[effect.full_name(each.name)] for each in effect.parameters}
        for term in effect.terms:
            if not term.writes[0].startswith(("object_x", "object_y", "object_angle")):
                continue
            own = {
                name: known[name] if name in known else states[:, layout[name]][:, 0]
                for name in term.arguments
            }
            found = plain(term.kernel)(**own)
            added = found if isinstance(found, tuple) else (found,)
            for name, each in zip(term.writes, added, strict=False):
                pose[:, ("object_x", "object_y", "object_angle").index(name)] += each
    return pose


def outlines(hand: Hand, shape: str) -> Outlines:
    """Sections of an object as drawn in space: of a sphere by its slices, else over `ACROSS`."""
    values = hand.parameters
    middle = values["object.z"]
    half = values["object.radius"] if shape == "sphere" else ACROSS
    planes = middle + half * np.linspace(-1.0, 1.0, 9)[1:-1]
    return outlines_at(hand, shape, planes)


def finger_outlines(hand: Hand, shape: str) -> Outlines:
    """Section of an object in each finger's plane."""
    planes = [hand.parameters[f"{finger}.mount_z"] for finger in FINGERS]
    return outlines_at(hand, shape, np.array(planes))


def outlines_at(hand: Hand, shape: str, planes: np.ndarray) -> Outlines:
    """Outlines of an object in the planes z [m] of the hand frame, before it turns."""
    values = hand.parameters
    offsets = planes - values["object.z"]
    radius, half_x, half_y = (values[f"object.{name}"] for name in ("radius", "half_x", "half_y"))
    pose = [values[f"object.{name}"] for name in ("turn", "tilt_x", "tilt_y")]
    pose = [0.0, 0.0, 0.0] if shape == "sphere" else pose
    xx, xy, yx, yy = frame(*pose)
    aside = np.outer(offsets, np.tan(pose[1:]))
    cuts = sections(shape, radius, half_x, half_y, offsets.tolist())
    made = []
    for cut, shift in zip(cuts, aside, strict=True):
        own = _rounded(*cut)
        made.append(own @ np.array([[xx, yx], [xy, yy]]) + shift)
    return Outlines(planes, np.array(made))


def _rounded(half_x: float, half_y: float, radius: float) -> np.ndarray:
    """Outline of a rounded rectangle about the origin [m], shape (n, 2)."""
    turns = np.linspace(0.0, 0.5 * np.pi, CORNER)
    corners = [(1, 1), (-1, 1), (-1, -1), (1, -1)]
    parts = []
    for k, (sign_x, sign_y) in enumerate(corners):
        angle = turns + 0.5 * np.pi * k
        rounding = radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        parts.append(rounding + np.array([sign_x * half_x, sign_y * half_y]))
    return np.concatenate(parts)
