"""Tilted and turned objects: sections and distances against solid geometry by brute force."""

import itertools

import numpy as np
import pytest
from runs import grasp
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation
from touch import Touch, moving

from hannes.contact.leaning import ARCH, nearest_place
from hannes.contact.shapes import frame
from hannes.core.errors import BadInput
from hannes.core.kernels.jit import plain
from hannes.dataset.sampling import sample_grasp
from hannes.dataset.spec import read_spec
from hannes.simulation.experiment.clearance import overlaps, require_clear
from hannes.simulation.experiment.experiment import Experiment, Target
from hannes.simulation.experiment.load import read
from hannes.simulation.hand.anatomy import FINGERS
from hannes.simulation.hand.hand import Hand
from hannes.simulation.simulate import simulate

SHAPES = {"cylinder": (0.0, 0.0, 0.026), "prism": (0.014, 0.009, 0.006)}


def poses(count=12):
    """Turn, tilts [rad] and height of the cut [m]."""
    rng = np.random.default_rng(4)
    for _ in range(count):
        yield rng.uniform(-0.6, 0.6, 3), rng.uniform(-0.03, 0.03)


def outside(point, shape, pose):
    """Distance [m] of points (..., 3) to the solid's surface across its axis, by rotations."""
    half_x, half_y, radius = SHAPES[shape]
    turn, tilt_x, tilt_y = pose
    axis = np.array([np.tan(tilt_x), np.tan(tilt_y), 1.0])
    axis /= np.linalg.norm(axis)
    swing = np.cross([0.0, 0.0, 1.0], axis)
    angle = np.arccos(axis[2]) / max(np.linalg.norm(swing), 1e-12)
    put = Rotation.from_rotvec(angle * swing) * Rotation.from_rotvec([0.0, 0.0, turn])
    own = np.abs(point @ put.as_matrix())[..., :2] - (half_x, half_y)
    inside = np.minimum(own.max(axis=-1), 0.0)
    return np.linalg.norm(np.maximum(own, 0.0), axis=-1) + inside - radius


def border(angles, shape, pose, height):
    """Points of the section's border, in directions from the axis' place, shape (n, 2)."""
    centre = height * np.tan(pose[1:])
    rays = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    low, high = np.zeros(len(angles)), np.full(len(angles), 0.2)
    for _ in range(60):
        middle = 0.5 * (low + high)
        at = centre + middle[:, np.newaxis] * rays
        out = outside(np.column_stack([at, np.full(len(at), height)]), shape, pose) > 0.0
        low, high = np.where(out, low, middle), np.where(out, middle, high)
    return centre + middle[:, np.newaxis] * rays


def searched(link, shape, pose, height):
    """Least distance [m] of a link's points to the section's border."""
    start, along, length = link

    def distance(x):
        point = border(np.array([x[0]]), shape, pose, height)[0]
        return np.linalg.norm(start + np.clip(x[1], 0.0, 1.0) * length * along - point)

    angles, places = np.linspace(0.0, 2.0 * np.pi, 721), np.linspace(0.0, 1.0, 101)
    on_link = start + places[:, np.newaxis] * length * along
    gaps = np.linalg.norm(border(angles, shape, pose, height)[:, np.newaxis] - on_link, axis=-1)
    a, b = np.unravel_index(gaps.argmin(), gaps.shape)
    how = {"xatol": 1e-9, "fatol": 1e-12, "maxiter": 2000}
    found = minimize(distance, (angles[a], places[b]), method="Nelder-Mead", options=how)
    return min(found.fun, gaps.min())


@pytest.mark.slow
@pytest.mark.parametrize("shape", SHAPES)
def test_distance_of_a_link_against_solid_geometry(shape):
    """Exact for cylinders; flat sides are arched by a hundredth of their half length."""
    rng = np.random.default_rng(5)
    half_x, half_y, _ = SHAPES[shape]
    arch = 1.3 * ARCH * (half_x + half_y) + 1e-8
    for pose, height in poses():
        angle, away = rng.uniform(0.0, 2.0 * np.pi, 2), rng.uniform(0.04, 0.06)
        start = away * np.array([np.cos(angle[0]), np.sin(angle[0])])
        along = np.array([np.cos(angle[1]), np.sin(angle[1])])
        centre = height * np.tan(pose[1:])
        section = (*SHAPES[shape], *frame(*pose))
        args = (*(start - centre), *along, 0.03, section)
        _, gap, *normal = nearest_place(*args)
        if gap < 1e-3:
            continue  # it runs through the section
        expected = searched((start, along, 0.03), shape, pose, height)
        assert expected - arch <= gap <= expected + 1e-7
        assert np.hypot(*normal) == pytest.approx(1.0)
        assert plain(nearest_place)(*args)[1] == pytest.approx(gap, abs=1e-14)


def test_a_turn_by_a_quarter_swaps_the_sides():
    a, b, r = SHAPES["prism"]
    link = (0.01, 0.04, 0.8, -0.6, 0.03)
    turned = nearest_place(*link, (a, b, r, *frame(np.pi / 2.0, 0.0, 0.0)))
    assert turned == pytest.approx(nearest_place(*link, (b, a, r, *frame(0.0, 0.0, 0.0))))


@pytest.mark.parametrize(
    ("shape", "tilt"), [("cylinder", {"object.tilt_x": 0.3, "object.tilt_y": -0.2})]
)
def test_its_rate_of_depth_is_the_rate_of_its_depth(shape, tilt):
    touch, step = Touch(shape, tilt), 1e-6
    for angles, speeds in moving():
        deeper, before = (touch(angles + s * step * speeds)("penetration")[:10] for s in (1, -1))
        mine = touch(angles, speeds)("penetration_rate")[:10]
        assert mine == pytest.approx((deeper - before) / (2.0 * step), rel=1e-5, abs=1e-7)


def test_every_phalanx_meets_the_section_in_its_own_plane():
    """All five fingers of the compiled hand, the mirrored thumb too, in the hand frame."""
    tilts = {"object.tilt_x": 0.3, "object.tilt_y": -0.2}
    touch, value, seen = Touch("cylinder", tilts), Hand().parameters, 0
    pose, around = (0.0, *tilts.values()), np.linspace(0.0, 2.0 * np.pi, 4001)
    for angles in [each for each, _ in moving()][:4]:
        depths = touch(angles)("penetration")
        for k, (finger, link) in enumerate(itertools.product(FINGERS, ("second", "third"))):
            mount = [value[f"{finger}.mount_{axis}"] - value[f"object.{axis}"] for axis in "xyz"]
            facing, start = value[f"{finger}.facing"], np.array(mount[:2])
            turns = np.cumsum(angles[2 * (k // 2) : 2 * (k // 2) + 2])
            ways = np.stack([np.cos(turns), -facing * np.sin(turns)], axis=1)
            if link == "third":
                start = start + value[f"{finger}.second_length"] * ways[0]
            places = np.linspace(0.0, value[f"{finger}.{link}_length"], 400)[:, np.newaxis]
            points = start + places * ways[k % 2]
            solid = np.column_stack([points, np.full(len(points), mount[2])])
            if outside(solid, "cylinder", pose).min() < 1e-3:
                continue  # its axis runs through the object
            edge = border(around, "cylinder", pose, mount[2])
            gap = np.linalg.norm(points[:, np.newaxis] - edge, axis=-1).min()
            assert depths[k] == pytest.approx(value[f"{finger}.radius"] - gap, abs=1e-6)
            seen += 1
    assert seen > 20


PRISM = {"object.half_x": 0.02, "object.half_y": 0.018, "object.radius": 0.008}


@pytest.mark.parametrize(("shape", "more", "off"), [("cylinder", {}, 1e-4), ("prism", PRISM, 0.02)])
def test_hardly_tilted_is_as_good_as_upright(shape, more, off):
    forces = []
    for tilt in (0.0, 1e-7):
        made = grasp(shape, tilt_x=tilt)
        target = Target(shape, {**made.object.values, **more})
        run = simulate(Hand(), Experiment("t", 0.7, made.reference, target)).require()
        forces.append(run["force"])
    assert np.abs(forces[1] - forces[0]).max() < off * forces[0].max()


def test_a_tilted_ball_is_the_same_ball():
    hand = Hand()
    tilted = hand.with_values({"object.tilt_x": 0.4, "object.turn": 1.0})
    same = hand.vector("sphere") == tilted.vector("sphere")
    assert (~same).sum() == 2  # the tilt and the turn themselves


def posed(**values):
    """A short grasp of a cylinder."""
    placed = {f"object.{name}": value for name, value in values.items()}
    return Experiment("t", 0.1, grasp().reference, Target("cylinder", placed))


def test_tilted_objects_must_stand_clear_of_the_open_hand():
    upright, known = (
        list(overlaps(Hand(), each).values()) for each in (posed(tilt_x=1e-9), posed())
    )
    assert upright == pytest.approx(known, abs=2e-7)
    with pytest.raises(BadInput, match="the object intersects the open hand"):
        require_clear(Hand(), posed(tilt_y=0.7), "x.toml")


TEXT = """
duration = "0.2 s"
[reference]
kind = "ramp"
points = [["0 s", "0 rad"], ["0.2 s", "3 rad"]]
"""
OBJECT = """
[object]
shape = "prism"
size = { width = "36 mm", height = "30 mm" }
position = ["14 mm", "-47 mm", "0 mm"]
turn = "10 deg"
tilt = ["15 deg", "-5 deg"]
"""


def test_files_hold_turn_and_tilt():
    (grasped,) = read(TEXT + OBJECT, "x.toml")
    found = grasped.experiment.object.values
    expected = {"object.turn": 10.0, "object.tilt_x": 15.0, "object.tilt_y": -5.0}
    assert {n: np.rad2deg(found[n]) for n in expected} == pytest.approx(expected)
    with pytest.raises(BadInput, match="tilt must be a list of 2 values"):
        read(TEXT + OBJECT.replace('["15 deg", "-5 deg"]', '["15 deg"]'), "x.toml")
    with pytest.raises(BadInput, match=r"tilt_x = 1.39.* above its upper bound 1"):
        read(TEXT + OBJECT.replace('"15 deg"', '"80 deg"'), "x.toml")


def test_data_sets_draw_poses():
    spec = read_spec(
        TEXT
        + """
[[grasps]]
shape = "cylinder"
draws = 5
[grasps.values]
"object.tilt_x" = { uniform = ["-20 deg", "20 deg"] }
"object.tilt_y" = { uniform = ["-10 deg", "10 deg"] }
"""
    )
    tilts = [sample_grasp(spec, k).experiment.object.values["object.tilt_x"] for k in range(5)]
    assert np.ptp(tilts) > 0.1 and np.abs(tilts).max() <= np.deg2rad(20.0)
