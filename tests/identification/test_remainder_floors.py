"""The floor of a remainder: what repeats show, and of few of them what is stated of runs."""

from types import SimpleNamespace

import numpy as np
import pytest

from hannes.identification.diagnosis.remainder_floors import remainder_floors, stated_spread
from hannes.identification.diagnosis.tuning import VERDICT

STATED = 0.3  # by which runs differ in the supply; in the current they do not


def noise(repeats):
    """One command with a current and a supply, ten bins of each, recorded so many times more."""
    places = {"current": slice(0, 10), "supply": slice(10, 20)}
    group = SimpleNamespace(count=1 + repeats, names=tuple(places), of=places.__getitem__)
    rows = np.zeros((2, 20))
    rows[0, places["supply"]], rows[1, places["supply"]] = 0.6 * STATED, -0.8 * STATED
    return SimpleNamespace(model=SimpleNamespace(groups=[group]), run_to_run=[rows])


@pytest.mark.parametrize("repeats", [0, 2, 50])
def test_few_repeats_count_beside_what_is_stated(repeats):
    found = remainder_floors({"current": 0.1, "supply": 0.1, "unknown": 0.2}, noise(repeats))
    assert found["current"] == 0.1 and found["unknown"] == 0.2
    weight = VERDICT.assumed_weight
    pooled = (repeats * 0.1**2 + weight * STATED**2) / (repeats + weight)
    assert found["supply"] == pytest.approx(pooled**0.5)


def test_what_is_stated_of_runs_is_known_for_each_sample_of_fitted_commands():
    known = noise(2)
    known.model.groups[0].entries = [SimpleNamespace(), SimpleNamespace()]
    known.model.groups[0].views = [SimpleNamespace(times=np.linspace(0.0, 1.0, 10))]
    known.run_to_run[0][:, 15:] = 0.0
    time, mask = np.linspace(3.0, 4.0, 101), np.arange(101) > 20
    fitted, other = (
        SimpleNamespace(entry=each, recording=SimpleNamespace(time=time), mask=mask)
        for each in (known.model.groups[0].entries[1], SimpleNamespace())
    )
    spread, unknown = stated_spread(known, [fitted, other])
    assert unknown == {} and spread["supply"].shape == (80,)
    assert spread["supply"][0] == pytest.approx(STATED) and spread["supply"][-1] == 0.0
    assert not spread["current"].any()


def test_repeats_that_differ_by_more_than_stated_keep_their_floor():
    assert remainder_floors({"supply": 0.5}, noise(2)) == {"supply": 0.5}
