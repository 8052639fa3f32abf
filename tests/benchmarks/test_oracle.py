"""The oracle: its test has the power it claims, and its search ends at that size."""

from argparse import Namespace

import numpy as np
import pytest

from benchmarks.oracle import search
from benchmarks.oracle.__main__ import amplitudes
from benchmarks.oracle.bench import Bench
from benchmarks.oracle.discriminant import FALSE_ALARM, POWER, Discriminant, needed
from benchmarks.oracle.expected_covariance import of_hands, of_joints, of_runs
from benchmarks.oracle.features import BINS, names, vector
from benchmarks.oracle.search import NEAR, searched
from benchmarks.oracle.store import Store, digest
from benchmarks.truth.campaign import Spread, make
from benchmarks.truth.effects import OUTSIDE
from benchmarks.truth.hidden import SIZES
from benchmarks.truth.protocol import DYNAMOMETER, POOR, Condition, Protocol
from hannes.core.errors import ComputationFailed

SIGNATURE = np.array([1.0, 1.0, 0.0, 0.0, 0.0])
MIXED = np.array([[3.0, 1, 0, 0, 0], [0, 0.5, 0, 2, 0], [0, 0, 1, 0, 0], [0, 0, 0, 1, 1.0]])
COVARIANCE = MIXED.T @ MIXED + 0.01 * np.eye(5)
BEST = 1.0 / np.sqrt(SIGNATURE @ np.linalg.solve(COVARIANCE, SIGNATURE))


def empties(count, seed=0):
    draws = np.random.default_rng(seed).standard_normal((count, 5))
    return draws @ np.linalg.cholesky(COVARIANCE).T + 7.0


@pytest.fixture(scope="module")
def oracle():
    return Discriminant(empties(2000), COVARIANCE)


def test_the_test_is_the_best_linear_one(oracle):
    empty, _ = oracle.scores(SIGNATURE, SIGNATURE[None])
    assert np.std(empty) == pytest.approx(BEST, rel=0.05)
    normal = 1.645 + 0.842  # quantiles of 95 % and 80 %
    assert needed(empty, 1.0) == pytest.approx(normal * BEST, rel=0.07)


def test_power_and_false_alarm_hold_on_campaigns_never_seen(oracle):
    empty, _ = oracle.scores(SIGNATURE, SIGNATURE[None])
    limit, u = np.quantile(empty, 1.0 - FALSE_ALARM), needed(empty, 1.0)
    fresh = empties(4000, seed=1) - 7.0
    weights = np.linalg.solve(COVARIANCE, SIGNATURE) * BEST**2
    assert np.mean(fresh @ weights > limit) == pytest.approx(FALSE_ALARM, abs=0.02)
    assert np.mean((fresh + u * SIGNATURE) @ weights > limit) == pytest.approx(POWER, abs=0.04)


def test_few_empties_lean_on_what_is_expected_of_them():
    empty, _ = Discriminant(empties(24), COVARIANCE).scores(SIGNATURE, SIGNATURE[None])
    assert np.std(empty) < 1.6 * BEST


def test_an_effect_against_its_signature_is_never_detected(oracle):
    empty, score = oracle.scores(SIGNATURE, -SIGNATURE[None])
    assert score == pytest.approx(-1.0) and needed(empty, score) == np.inf


@pytest.mark.parametrize("begin", [1e-3, 3.0, 80.0])
def test_a_search_ends_at_the_size_that_is_detected(oracle, begin):
    def change(u, first, count):
        if u > 90.0:
            raise ComputationFailed("stuck")
        noise = 0.01 * np.random.default_rng(first).standard_normal((count, 5))
        return (u + 0.2 * u**2) * SIGNATURE + noise

    found = searched(change, oracle, 100.0, begin, 3)
    normal = 2.487 * BEST
    assert found + 0.2 * found**2 == pytest.approx(normal, rel=NEAR - 1.0)


def test_a_search_knows_what_lies_beyond_the_physical_range(oracle):
    def change(u, first, count):
        return np.tile(0.01 * u * SIGNATURE, (count, 1))

    assert searched(change, oracle, 1.0, 0.1, 2) is None
    assert searched(lambda u, first, count: np.zeros((count, 5)), oracle, 1.0, 0.1, 2) is None


PRESSED = Condition("dynamometer", ((0.0, 0.0), (0.1, 1.5)), 2, DYNAMOMETER, sensor=True)
FREE = Condition("void", ((0.0, 0.0), (0.1, 1.5)), 1)
BLINK = Protocol((FREE, PRESSED), POOR)


def test_a_vector_is_a_mean_over_repeats_in_the_order_of_conditions():
    made = make(BLINK, 1)
    found = vector(made, BLINK).reshape(-1, BINS)
    wanted = [names(BLINK, each) for each in BLINK.conditions]
    assert wanted[1] == ["position", "current", "force", "sensor", "within current"]
    assert found.shape[0] == len(wanted[0]) + len(wanted[1])
    pressed = [made.recordings[name]["current"] for name in ("02_dynamometer", "03_dynamometer")]
    pieces = np.array_split(np.mean(pressed, axis=0), BINS)
    np.testing.assert_allclose(found[4], [piece.mean() for piece in pieces])


def test_what_scatters_has_a_slope_and_is_simulated_once(tmp_path, monkeypatch):
    monkeypatch.setattr("benchmarks.oracle.bench.PROTOCOLS", {"blink": BLINK})
    bench = Bench("blink", Store(tmp_path))
    moved = [deviation for slope, deviation in of_hands(bench, Spread())]
    assert len(moved) == 84 and set(moved) == {0.02, 0.2 * 0.001}
    assert len(of_runs(bench, Spread())) > 10
    files = {path: path.stat().st_mtime_ns for path in tmp_path.rglob("*.npy")}
    of_hands(Bench("blink", Store(tmp_path)), Spread())
    assert files == {path: path.stat().st_mtime_ns for path in tmp_path.rglob("*.npy")}
    change = bench.change("leader_slack.length", 3e-3, 0)
    assert np.abs(change).max() > 0.0


def test_another_truth_is_another_folder(tmp_path):
    (tmp_path / "one.py").write_text("A = 1\n")
    before = digest(tmp_path)
    assert digest(tmp_path) == before
    (tmp_path / "one.py").write_text("A = 2\n")
    assert digest(tmp_path) != before


def test_joints_that_are_off_for_themselves_scatter_too(tmp_path, monkeypatch):
    monkeypatch.setattr("benchmarks.oracle.bench.PROTOCOLS", {"blink": BLINK})
    apart = Spread(finger=0.01)
    bench = Bench("blink", Store(tmp_path), apart)
    joints = of_joints(bench, apart)
    assert len(joints) == 60 and {deviation for _, deviation in joints} == {0.01}
    assert sum(bool(np.any(slope)) for slope, _ in joints) > 30
    alike = Bench("blink", Store(tmp_path))
    assert not np.allclose(bench.empty(0), alike.empty(0))


def test_effects_with_a_name_and_settings_are_searched_where_fingers_are_apart():
    asked = Namespace(effect=None, fingers_apart=True)
    names = amplitudes(asked)
    assert {"guide_load.coefficient", "mounting.along_x", "current_limit.change"} <= set(names)
    outside = {each.__name__.rpartition(".")[2] for each in OUTSIDE}
    assert not outside & {name.partition(".")[0] for name in names}


@pytest.mark.parametrize("name", ["current_limit.change", "firmware_gains.proportional"])
def test_a_range_is_searched_by_sign_up_to_its_own_end(name, monkeypatch):
    ends = []
    monkeypatch.setattr(search, "searched", lambda *asked: ends.append(asked[2]) or asked[2])
    found = search.smallest(name, {}, None, None, 1, 1.0)
    assert list(found.found) == list(SIZES[name].signs)
    assert ends == [most for _, _, most in SIZES[name].signs.values()]
