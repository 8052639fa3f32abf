"""Stiffness by traces: its inputs, its networks against plain numpy, its training and its file."""

from dataclasses import replace

import h5py
import numpy as np
import pytest

from hannes.bench.c_vectors import drawn
from hannes.bench.live import warm_up
from hannes.core.errors import BadInput
from hannes.dataset.spec import load_spec
from hannes.recognition import model_file
from hannes.recognition.pressed import (
    AFTER,
    BEFORE,
    EARLIEST,
    GROUP,
    INPUTS,
    LATEST,
    START,
    TRACE,
    PressedStiffness,
    bin_size,
    due,
    trace_inputs,
)
from hannes.recognition.train_pressed import Known, _touches, fitted
from hannes.recognition.windowing import GrowingFeatures, Windowing
from tests.bench.drawn_model import HANDS, NUMBERS, drawn_model, drawn_networks

MEAN = 0.02  # s, of one mean of the traces


def test_inputs_of_straight_lines_are_their_means():
    time = np.arange(1100) / 1000.0
    samples = np.stack([0.3 + 2.0 * time, 4.0 * time, 5.0 * time])
    found = trace_inputs(samples, 400, 1000.0)
    middle = 0.4 + MEAN * (np.arange(TRACE) - BEFORE + 0.5) - 0.5e-3
    assert found[:TRACE] == pytest.approx(0.3 + 2.0 * middle)
    assert found[TRACE : 2 * TRACE] == pytest.approx(4.0 * (middle - 0.4))
    assert found[2 * TRACE : 3 * TRACE] == pytest.approx(middle)
    begun = MEAN * (np.arange(START) + 0.5) - 0.5e-3
    assert found[3 * TRACE : 3 * TRACE + START] == pytest.approx(0.3 + 2.0 * begun)
    assert found[3 * TRACE + START : -2] == pytest.approx(begun)
    assert found[-2:] == pytest.approx([1.6, 0.4])


@pytest.mark.parametrize("is_known", [False, True])
def test_networks_are_those_of_plain_numpy(is_known):
    known = drawn_networks()
    rows = np.random.default_rng(1).normal(0.0, 2.0, (5, INPUTS))
    hand = known.points(np.random.default_rng(2).normal(0.3, 0.1, NUMBERS)) if is_known else None
    points = (rows - known.centre) @ known.mix.astype(float).T
    more = np.tile(np.zeros(HANDS) if hand is None else hand, (5, 1))
    wanted = []
    for layers in zip(known.first, known.second, known.last, strict=True):
        values = np.hstack([points, more])
        for k, each in enumerate(layers):
            values = values @ each[:, :-1].T.astype(float) + each[:, -1]
            values = np.maximum(values, 0.0) if k < 2 else values
        wanted.append(values[:, 0])
    assert known(rows, hand) == pytest.approx(np.mean(wanted, axis=0), rel=1e-12)
    assert is_known == (known(rows, hand) != known(rows)).all()


def test_beyond_what_was_learned_from_there_is_no_estimate():
    known = drawn_networks()
    row = np.full((1, INPUTS), 1.0)
    near = float(np.abs((row - known.centre) @ known.mix.T).max())
    assert np.isfinite(replace(known, reach=np.array([1.01 * near, 1.0, 1.0, 1.0]))(row)[0])
    assert np.isnan(replace(known, reach=np.array([0.99 * near, 1.0, 1.0, 1.0]))(row)[0])


def test_the_estimate_is_due_once_the_traces_are_there():
    assert bin_size(1000.0) == 5 and bin_size(500.0) == 0 and bin_size(200.0) == 1
    assert due(403, 5) == (403 // 5 + GROUP * AFTER) * 5
    assert due(5 * EARLIEST - 1, 5) is None and due(5 * LATEST, 5) is None
    assert due(403, 0) is None


def test_training_reads_the_touch_that_is_seen_live():
    windowing = Windowing()
    grasps = np.stack([drawn(seed, 1100, 1e-3) for seed in range(40, 46)])
    for touch, samples in zip(_touches(grasps, windowing), grasps, strict=True):
        growing = GrowingFeatures(windowing)
        growing.take(list(samples))
        assert touch == growing.touch


def known(rows, target, others=None, hands=None):
    """Grasps as training has them."""
    none = np.zeros((target.size, 0))
    return Known(rows, target, *(none if each is None else each for each in (others, hands)))


@pytest.fixture(scope="module")
def learned():
    """Networks that learned a curved function of some of their inputs, and unseen rows of it."""
    chance = np.random.default_rng(3)
    hidden = chance.normal(0.0, 1.0, (1500, 4))
    rows = 0.01 * hidden @ chance.normal(0.0, 1.0, (4, INPUTS))
    rows += chance.normal(0.0, 1e-5, rows.shape)
    target = 8.6 + 0.5 * hidden[:, 0] + 0.1 * hidden[:, 1] ** 2
    return fitted(known(rows[:1200], target[:1200]), 8.6, 0), rows[1200:], target[1200:]


def test_the_shipped_set_presses_on_objects_as_weak_and_as_stiff_as_any():
    groups = [group for group in load_spec("held").groups if group.role == "pressed"]
    rng = np.random.default_rng(0)
    found = [
        group.distributions["object.stiffness"].value(0, 0.0, rng)
        for group in groups
        for _ in range(2000)
    ]
    assert min(found) < 500.0 and max(found) > 40e3


def test_networks_learn_a_curve_and_say_how_well(learned):
    made, rows, target = learned
    found = made(rows)
    seen = np.isfinite(found)
    off = float(np.sqrt(np.mean((found - target)[seen] ** 2)))
    assert seen.mean() > 0.95
    assert off < 0.3 * target.std()
    assert made.error == pytest.approx([off, off], rel=0.7)


def test_what_is_learned_beside_the_stiffness_is_not_kept(learned):
    made, rows, target = learned
    alone = fitted(known(rows, target), 8.6, 0)
    others = np.random.default_rng(1).normal(size=(target.size, 3))
    beside = fitted(known(rows, target, others=others), 8.6, 0)
    assert beside.last.shape == alone.last.shape == made.last.shape
    assert not np.array_equal(beside.first, alone.first)


def test_the_same_rows_give_the_same_networks(learned):
    made, rows, _ = learned
    given = known(rows, rows[:, 0] + 8.6)
    again = fitted(given, 8.6, 1)
    assert np.array_equal(again(rows), fitted(given, 8.6, 1)(rows), equal_nan=True)
    assert not np.array_equal(again.first, made.first)


def test_a_model_file_keeps_them_to_the_bit(tmp_path):
    model = drawn_model()
    model_file.write(tmp_path / "m.h5", model)
    found = model_file.read(tmp_path / "m.h5").pressed
    for name, each in vars(model.pressed).items():
        assert np.array_equal(getattr(found, name), each)
    model_file.write(tmp_path / "n.h5", replace(model, pressed=None))
    assert model_file.read(tmp_path / "n.h5").pressed is None


def test_networks_are_compiled_before_a_hand_moves():
    asked = []
    model = drawn_model()

    class Asked(PressedStiffness):
        def __call__(self, rows, hand=None):
            asked.append(rows.shape)

        def points(self, numbers):
            asked.append(numbers.shape)

    warm_up(replace(model, pressed=Asked(**vars(model.pressed))))
    assert asked == [(1, INPUTS), (NUMBERS,)]


@pytest.mark.parametrize("name, value", [("last", np.nan), ("reach", -1.0), ("error", 9.0)])
def test_a_damaged_network_is_refused(name, value, tmp_path):
    model_file.write(tmp_path / "m.h5", drawn_model())
    with h5py.File(tmp_path / "m.h5", "r+") as file:
        file[f"pressed/{name}"][...] = value
    with pytest.raises(BadInput, match="pressed"):
        model_file.read(tmp_path / "m.h5")


def test_an_empty_closure_that_shows_the_hand_is_learned():
    """What the traces do not show of a hand, its closure on nothing does."""
    chance = np.random.default_rng(4)
    hidden, slack = chance.normal(0.0, 1.0, (1500, 4)), chance.normal(0.0, 1.0, 1500)
    rows = 0.01 * hidden @ chance.normal(0.0, 1.0, (4, INPUTS))
    rows += chance.normal(0.0, 1e-5, rows.shape)
    hands = 0.3 + 0.1 * np.outer(slack, chance.normal(0.0, 1.0, 20))
    hands[::7] = np.nan  # these did not close on nothing
    target = 8.6 + 0.3 * hidden[:, 0] + 0.2 * slack
    made = fitted(known(rows[:1200], target[:1200], hands=hands[:1200]), 8.6, 0)
    assert made.hand_centre.shape == (20,) and made.error[1] < 0.6 * made.error[0]
    unseen = [k for k in range(1200, 1500) if np.isfinite(hands[k]).all()]
    points = [made.points(hands[k]) for k in unseen]
    predicted = [
        made(rows[[k]], p)[0] for k, p in zip(unseen, points, strict=True) if p is not None
    ]
    wanted = [target[k] for k, p in zip(unseen, points, strict=True) if p is not None]
    assert len(predicted) > 0.9 * len(unseen)
    assert np.nanstd(np.subtract(predicted, wanted)) < 0.1  # of 0.2 that the slack alone makes


def test_the_error_with_a_known_hand_counts_no_hand_without_a_closure():
    """What hands that did not close on nothing are off is no error of known ones."""
    chance = np.random.default_rng(5)
    slack = chance.normal(0.0, 1.0, 500)
    rows = chance.normal(0.0, 0.01, (500, INPUTS))
    hands = 0.3 + 0.1 * np.outer(slack, chance.normal(0.0, 1.0, 20))
    target = 8.6 + 0.05 * slack
    hands[::2] = np.nan
    target[::2] += chance.normal(0.0, 0.2, 250)  # nothing shows it
    made = fitted(known(rows, target, hands=hands), 8.6, 0)
    assert made.error[1] < 0.12 < 0.14 < made.error[0]


def test_a_hand_beyond_those_that_were_learned_from_has_no_points():
    made = drawn_networks()
    assert made.points(np.full(NUMBERS, 1e5)) is None
    assert made.points(np.full(NUMBERS, np.nan)) is None
    assert made.points(made.hand_centre).tolist() == [0.0] * HANDS


def test_each_point_of_a_hand_has_a_reach_of_its_own():
    made = drawn_networks()
    numbers = made.hand_centre + np.eye(NUMBERS)[3]
    points = made.points(numbers)
    for k in range(HANDS):
        reach = made.reach.copy()
        reach[1 + k] = 0.99 * abs(points[k])
        assert replace(made, reach=reach).points(numbers) is None
