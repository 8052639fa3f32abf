"""A supply that falls from run to run is named, and its runs are shown with what each had."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.truth.battery import FALL
from benchmarks.truth.campaign import Spread, make
from benchmarks.truth.protocol import DYNAMOMETER, PAPER, RICH, Condition, Protocol
from hannes.commands.diagnose import diagnose

RUNS = Protocol(
    (Condition("void", PAPER, 3), Condition("dynamometer", PAPER, 5, DYNAMOMETER, sensor=True)),
    RICH,
)
FELL = 0.15  # V
ONE = Protocol((Condition("void", PAPER, 8),), RICH)


class Turns(Protocol):
    """Conditions that take turns."""

    @property
    def runs(self):
        return list(self.conditions) * 5


TURNS = Turns(tuple(replace(each, repeats=1) for each in RUNS.conditions), RICH)


def diagnosed(out, protocol, seed, fell):
    make(protocol, seed, {FALL: fell} if fell else {}, Spread(finger=0.01)).write(out)
    return diagnose(out / "campaign.toml", progress=False)


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    return diagnosed(tmp_path_factory.mktemp("fell"), RUNS, 3, FELL)


@pytest.mark.parametrize(("protocol", "fell"), [(TURNS, 0.06), (ONE, 0.06), (ONE, 0.0)])
def test_repeats_show_it_where_means_over_them_do_not(tmp_path, protocol, fell):
    verdict = diagnosed(tmp_path, protocol, 7, fell).verdict
    assert verdict.effects == (["falling_supply"] if fell else [])
    if fell:
        size = verdict.parameters["falling_supply.fall"]
        assert size["low"] < fell < size["high"]
    else:
        assert verdict.verdict == "recalibrated"


def test_it_is_named_and_its_size_is_right(found):
    assert found.verdict.effects == ["falling_supply"]
    size = found.verdict.parameters["falling_supply.fall"]
    assert size["value"] == pytest.approx(FELL, rel=0.15)


def test_the_gap_of_runs_that_were_not_fitted_falls(found):
    gap = found.verdict.gap["supply"]
    assert gap["after"] < 0.3 * gap["before"]


def test_each_run_is_simulated_with_the_supply_that_it_had(found):
    shown = [each for each in found.details.traces if "supply" in each.after]
    levels = {each.entry.number: float(np.median(each.after["supply"])) for each in shown}
    first, last = min(levels), max(levels)
    assert levels[first] - levels[last] == pytest.approx((last - first) * FELL, rel=0.2)
