"""Recordings of one command whose stamps jitter or lost samples become repeats of each other."""

from dataclasses import replace

import numpy as np
import pytest

from hannes.campaigns.campaign import Campaign, Entry
from hannes.campaigns.one_grid import on_one_grid
from hannes.campaigns.warnings import across_runs
from hannes.core.recording.recording import Recording
from hannes.plants.hand.plant import HandPlant

STEP, COUNT = 1e-3, 800
EVEN = STEP * np.arange(COUNT)
UNITS = {"time": "s", "reference": "rad", "position": "rad", "current": "A"}
PLANT = HandPlant()


def run(seed, jitter=0.0, lost=(), slow=1.0):
    """A ramp, read at times that are stamped with jitter [steps], without some samples."""
    rng = np.random.default_rng(seed)
    time = EVEN * slow + jitter * STEP * rng.uniform(-1.0, 1.0, COUNT) * (EVEN > 0.0)
    reference = np.minimum(8.0 * EVEN / 0.5, 8.0)
    position = reference + 1e-3 * rng.standard_normal(COUNT)
    channels = {"time": time, "reference": reference, "position": position,
                "current": 0.2 + 0.01 * rng.standard_normal(COUNT)}  # fmt: skip
    kept = np.setdiff1d(np.arange(COUNT), lost)
    return Recording({n: each[kept] for n, each in channels.items()}, UNITS, "hand")


def entries(*runs):
    return [Entry(f"{k}.csv", each, "closing") for k, each in enumerate(runs)]


def groups(made):
    return len({PLANT.same_run(each.recording) for each in made})


def test_stamps_that_jitter_leave_the_samples_as_they_are():
    given = entries(run(1, 0.04), run(2, 0.04), run(3, 0.04))
    made = on_one_grid(PLANT, given)
    assert (groups(given), groups(made)) == (3, 1)
    for old, new in zip(given, made, strict=True):
        assert new.recording["position"] == pytest.approx(old.recording["position"], abs=1e-12)
    assert np.diff(made[0].recording.time) == pytest.approx(STEP, rel=1e-9)


def test_samples_that_are_taken_early_or_late_are_interpolated():
    given = entries(run(1, 0.3), run(2, 0.3))
    made = on_one_grid(PLANT, given)
    assert groups(made) == 1
    first, time = given[0].recording, made[0].recording.time
    wanted = np.interp(time, first.time, first["position"])
    assert made[0].recording["position"] == pytest.approx(wanted, abs=2e-3)


def test_a_few_lost_samples_are_interpolated():
    given = entries(run(1, 0.02, lost=(100, 400, 401)), run(2, lost=(7,)), run(3))
    made = on_one_grid(PLANT, given)
    assert groups(made) == 1 and {len(each.recording) for each in made} == {COUNT}
    near = given[0].recording["position"][[99, 100]]
    assert near.min() <= made[0].recording["position"][100] <= near.max()


def test_a_run_alone_with_stamps_that_jitter_is_read_at_the_ticks():
    """A sample stamped before its tick would be simulated as the tick before."""
    (made,) = on_one_grid(PLANT, entries(run(1, 0.04)))
    assert made.recording.time == pytest.approx(EVEN, abs=1e-9)
    early = entries(run(1, 0.3))  # taken at other times: as they were recorded
    assert on_one_grid(PLANT, early) == early


@pytest.mark.parametrize("jitter", [0.02, 0.2])
def test_an_encoder_stays_in_whole_counts(jitter):
    """Firmware is recognised by them: half a count between two would hide it."""
    given = [run(k, jitter, lost=(100, 200 + k, 333)) for k in (1, 2, 3)]
    count = 2.0 * np.pi / 4096
    counted = [
        replace(r, channels={**r.channels, "position": count * np.rint(r["position"] / count)})
        for r in given
    ]
    made = on_one_grid(PLANT, entries(*counted))
    assert groups(made) == 1
    for each in made:
        counts = each.recording["position"] / count
        assert counts == pytest.approx(np.rint(counts), abs=1e-6)
        apart = counts - each.recording["reference"] / count  # 10 counts from sample to sample
        assert np.sqrt(np.mean(apart**2)) < 1.2
        lost = apart[[100, 202, 203, 333]]
        assert np.abs(lost).max() < 4.0


@pytest.mark.parametrize(
    "other",
    [run(2, lost=range(300, 330)), run(2, slow=1.05), run(2, lost=range(500, COUNT))],
    ids=["a gap", "another rate", "a shorter run"],
)
def test_what_fits_no_such_grid_stays_as_it_was_recorded(other):
    given = entries(run(1, 0.04), other)
    assert on_one_grid(PLANT, given) == given


def begun(run, at):
    """The same run without its command, read and begun at another time, as if it was aligned."""
    time = run.time + at
    channels = {n: run[n] for n in ("position", "current")}
    units = {n: UNITS[n] for n in ("time", *channels)}
    return replace(run, channels={"time": time, **channels}, units=units)


def test_runs_that_were_aligned_each_for_itself_are_repeats():
    given = [begun(run(k), at) for k, at in ((1, -0.0312), (2, -0.0247), (3, -0.0309))]
    made = on_one_grid(PLANT, entries(*given))
    assert groups(entries(*given)) == 3 and groups(made) == 1
    time = made[0].recording.time
    assert time[0] == -0.0247 and time[-1] <= min(each.time[-1] for each in given)
    for old, new in zip(given, made, strict=True):
        wanted = np.interp(time, old.time, old["position"])
        assert new.recording["position"] == pytest.approx(wanted, abs=1e-9)
    early = entries(given[0], begun(run(2), -0.2))  # a quarter of the run earlier
    assert on_one_grid(PLANT, early) == early


def test_other_commands_and_even_clocks_stay_apart_to_the_bit():
    slower = run(2)
    slower = replace(slower, channels={**slower.channels, "reference": 0.9 * slower["reference"]})
    given = entries(run(1, 0.04), slower)
    made = on_one_grid(PLANT, given)
    assert [each.recording for each in made] == [each.recording for each in given]
    even = entries(run(1), run(2))
    assert [each.recording for each in on_one_grid(PLANT, even)] == [e.recording for e in even]


def test_a_copy_of_a_recording_gets_a_warning():
    given = [*entries(run(1), run(2)), Entry("again.csv", run(1), "closing")]
    campaign = Campaign(PLANT, PLANT, tuple(given), None, {})
    said = [str(each) for each in across_runs(campaign) if each.kind == "copy"]
    assert len(said) == 1 and "again.csv has the same readings as 0.csv" in said[0]
