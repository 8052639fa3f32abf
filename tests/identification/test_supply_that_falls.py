"""A supply that falls from run to run is named, and its runs are shown with what each had."""

from pathlib import Path

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


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    out: Path = tmp_path_factory.mktemp("fell")
    make(RUNS, 3, {FALL: FELL}, Spread(finger=0.01)).write(out)
    return diagnose(out / "campaign.toml", progress=False)


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
