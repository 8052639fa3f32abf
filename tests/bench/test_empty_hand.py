"""A hand that is known by its closure on nothing: live, on the panel, and in a raw log."""

from dataclasses import replace

import numpy as np
import pytest
from drawn_model import NUMBERS, drawn_model

from hannes import Hand, load_experiment
from hannes.bench.c_vectors import drawn
from hannes.bench.events import About, Row
from hannes.bench.grip_loop import GripLoop
from hannes.bench.live_run import known_by
from hannes.bench.panel.traces import Traces
from hannes.commands.cli import main
from hannes.commands.cli_bench import known_hand
from hannes.core.errors import BadInput
from hannes.core.recording.recording import Recording
from hannes.recognition import model_file
from hannes.recognition.known_hand import unknown_hand

UNITS = {"time": "s", "current": "A", "position": "rad", "reference": "rad"}


@pytest.fixture(scope="module")
def model():
    return drawn_model()


def last(model, hand):
    """Stiffness by the traces of a drawn grasp, through the loop of a live grasp."""
    loop, said = GripLoop(model, hand=hand), []
    channels = {"current": "A", "position": "rad", "reference": "rad"}
    loop.feed(About("x", channels, 1000.0, 0.2), 0.0)
    for k, row in enumerate(drawn(20, 1150, 1e-3)):
        said += loop.feed(Row(k, 1e-3 * k, tuple(row)), 9.0).decisions
    return next(each.pressed for each in said[::-1] if each.pressed)


def test_a_known_hand_changes_the_estimate_and_narrows_it(model):
    known, unknown = last(model, np.full(NUMBERS, 0.5)), last(model, None)
    assert known.value != pytest.approx(unknown.value, rel=1e-3)
    assert np.log(known.high / known.low) == pytest.approx(0.5 * np.log(unknown.high / unknown.low))
    assert last(model, model.pressed.hand_centre).value == unknown.value  # the middle one


def test_a_hand_of_another_count_of_numbers_is_refused(model):
    for count in (NUMBERS - 1, NUMBERS + 1):
        with pytest.raises(BadInput, match="no numbers of an empty closure"):
            GripLoop(model, hand=np.full(count, 0.5))


def test_a_raw_log_keeps_what_the_closure_showed(model):
    numbers = np.full(NUMBERS, 0.5)
    assert known_by({}, model) is None
    assert np.array_equal(known_by({"empty_closure": numbers.tolist()}, model), numbers)
    lists = ([value] * NUMBERS for value in ("x", 1e9, [0.5], 10**400, True))
    for damaged in ("x", [0.5], *lists):
        with pytest.raises(BadInput):
            known_by({"empty_closure": damaged}, model)


@pytest.mark.parametrize("more", [[], ["--close", "void-closure", "--no-policy"], ["--json"]])
def test_a_hand_that_is_not_known_is_named_once(model, tmp_path, capsys, more):
    """Whatever is asked for: watched alone, without the policy, in a pipe."""
    given = tmp_path / "model.h5"
    model_file.write(given, model)
    assert main(["live", "/dev/no-such-port", str(given), *more]) == 2
    assert capsys.readouterr().err.count(unknown_hand(model)) == 1
    model_file.write(given, replace(model, pressed=None))
    assert main(["live", "/dev/no-such-port", str(given), *more]) == 2
    assert "the hand is not known" not in capsys.readouterr().err


def test_a_panel_refuses_a_hand_unlike_all_before_it_serves(model):
    with pytest.raises(BadInput, match="unlike all"):
        Traces(Hand(), load_experiment("void-closure")[0].experiment, model, np.full(NUMBERS, 1e8))


def test_a_closure_that_is_none_is_refused_before_a_port_is_opened(model, tmp_path, capsys):
    path, given = tmp_path / "short.h5", tmp_path / "model.h5"
    time = np.arange(300) / 1e3
    channels = {"time": time, **dict.fromkeys(list(UNITS)[1:], time)}
    Recording(channels, UNITS).write(path)
    model_file.write(given, model)
    command = ["live", "socket://127.0.0.1:9", str(given), "--close", "dynamometer"]
    assert main([*command, "--empty", str(path)]) == 2
    assert "short.h5: the empty closure is too short" in capsys.readouterr().err
    model_file.write(given, replace(model, pressed=None))
    assert main([*command, "--empty", str(path)]) == 2
    assert "nothing of empty closures" in capsys.readouterr().err
    assert main(["panel", "socket://127.0.0.1:9", "--empty", str(path)]) == 2
    assert "--model" in capsys.readouterr().err


def test_a_file_of_an_empty_closure_that_is_cut_off_is_named_once(model, tmp_path):
    path = tmp_path / "empty.h5"
    time = np.arange(9) * 1e-3
    Recording({"time": time, "current": time}, {"time": "s", "current": "A"}).write(path)
    path.write_bytes(path.read_bytes()[:-1])
    with pytest.raises(BadInput) as refused:
        known_hand(str(path), model)
    assert str(refused.value).count("empty.h5") == 1
