"""The Recording class: what it is at birth, what it refuses, how it is cut and extended."""

import pickle

import numpy as np
import pytest

from hannes.core.errors import BadInput
from hannes.core.recording.recording import Recording

UNITS = {"time": "s", "current": "A", "force": "N"}


def recording(**changes: object) -> Recording:
    time = np.arange(5) * 0.1
    content = {
        "channels": {"current": time**2, "time": time, "force": [0, 1, 2, 3, 4]},
        "units": UNITS,
        "plant": "hand",
        "seed": 3,
    }
    return Recording(**(content | changes))  # type: ignore[arg-type]


def with_channel(name: str, values: object, unit: str | None = "1") -> Recording:
    units = UNITS if unit is None else UNITS | {name: unit}
    return recording(channels=dict(recording().channels) | {name: values}, units=units)


def test_time_comes_first_and_everything_is_a_read_only_copy() -> None:
    time = np.arange(3.0)
    born = Recording({"current": time, "time": time}, {"current": "A", "time": "s"})
    time[:] = 0
    assert list(born.channels) == ["time", "current"] and born.names == ("current",)
    assert born.time.tolist() == [0, 1, 2] and born["current"].dtype == np.float64
    with pytest.raises(ValueError, match="read-only"):
        born.time[0] = 1
    with pytest.raises(TypeError):
        born.units["time"] = "h"  # type: ignore[index]


def test_equality_pickle_and_short_text() -> None:
    one = recording()
    assert one == recording() and pickle.loads(pickle.dumps(one)) == one
    assert one != recording(seed=4) and one != with_channel("force", [0, 1, 2, 3, 5], None)
    assert one != 1 and len(one) == 5 and "force" in one and "gap" not in one
    expected = (
        "Recording(measured, plant hand: 5 samples, 0 to 0.4 s; current [A], force [N])"  # one line
    )
    assert repr(one) == str(one) == expected


@pytest.mark.parametrize(
    ("name", "values", "unit", "message"),
    [
        ("duty", [0, 1, 2, np.nan, 4], "1", '"duty" is not finite at sample 3'),
        ("duty", [0, 1, 2, 3, np.inf], "1", "not finite"),
        ("duty", [0, 1], "1", "has 2 samples, time has 5"),
        ("duty", [[0, 1, 2, 3, 4]], "1", "expected a row of real numbers"),
        ("duty", [[0], [1, 2]], "1", "expected a row of real numbers"),
        ("duty", list("abcde"), "1", "expected a row of real numbers"),
        ("duty", [0j] * 5, "1", "expected a row of real numbers"),
        ("duty", [True] * 5, "1", "expected a row of real numbers"),
        ("duty", np.ma.masked_equal([0, 1, 2, 3, 4], 2), "1", "expected a row of real numbers"),
        ("duty", None, "1", "expected a row of real numbers"),
        ("duty", range(5), None, 'needs a unit \\("1" for none\\)'),
        ("duty", range(5), "", "needs a unit"),
        ("duty", range(5), "a_b", "needs a unit"),
        ("duty", range(5), "N,m", "needs a unit"),
        ("du,ty", range(5), "1", "no channel name"),
        ("", range(5), "1", "no channel name"),
        ("../x", range(5), "1", "no channel name"),
        ("time", [0, 1, 2, 2, 3], "s", "does not increase from sample 2 to 3"),
        ("time", [0, 1, 2, 3, 4], "ms", "time_s"),
    ],
)
def test_refuses_what_is_no_channel(
    name: str, values: object, unit: str | None, message: str
) -> None:
    with pytest.raises(BadInput, match=message) as caught:
        with_channel(name, values, unit)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "changes",
    [
        {"channels": {"time": [0, 1]}, "units": {"time": "s"}},
        {"channels": {"current": [0, 1]}, "units": {"current": "A"}},
        {"channels": {"time": [0], "current": [0]}, "units": {"time": "s", "current": "A"}},
        {"channels": {}, "units": {}},
        {"units": UNITS | {"other": "1"}},
        {"source": "dreamt"},
        {"schema": "hannes-recording-99"},
        {"seed": -1},
        {"seed": 2**63},
        {"seed": 1.5},
        {"seed": True},
        {"hand": None},
        {"experiment": "a\0b"},
        {"experiment": "\ud800"},
    ],
)
def test_refuses_what_is_no_recording(changes: dict[str, object]) -> None:
    with pytest.raises(BadInput):
        recording(**changes)


def test_with_channels_and_between() -> None:
    more = recording().with_channels({"duty": np.ones(5), "force": np.zeros(5)}, {"duty": "1"})
    assert more.names == ("current", "force", "duty") and more["force"].sum() == 0
    assert more.plant == "hand" and recording()["force"].sum() == 10
    part = more.between(0.1, 0.35)
    assert part.time.tolist() == more.time[1:4].tolist() and len(part["duty"]) == 3
    with pytest.raises(BadInput, match="fewer than two samples lie between 1 and 2 s"):
        more.between(1, 2)


def test_expect_names_the_nearest_channel_and_the_unit() -> None:
    declared = {"current": "A", "force": "N", "position": "rad"}
    one = recording()
    assert one.expect(declared) is one
    with pytest.raises(BadInput, match='no channel "position"'):
        one.expect(declared, required=["position"])
    with pytest.raises(BadInput, match=r'"duty" is unknown to the hand .*declares current, force'):
        with_channel("duty", range(5)).expect(declared, what="the hand")
    with pytest.raises(BadInput, match='did you mean "position"'):
        with_channel("postion", range(5), "rad").expect(declared)
    with pytest.raises(BadInput, match='"current" comes in mA, expected A: convert'):
        with_channel("current", range(5), "mA").expect(declared)
    with pytest.raises(BadInput, match='no channel "forse"; did you mean "force"'):
        one["forse"]
