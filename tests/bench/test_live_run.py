"""A live grasp through a port: the same afterwards, and a stop however it ends."""

import os
import pty
import signal
import subprocess
import sys
import time
import tty
from dataclasses import replace

import numpy as np
import pytest

from hannes import Hand, load_experiment
from hannes.bench.adapters import adapter
from hannes.bench.board_logic import Limits
from hannes.bench.events import Status
from hannes.bench.force_observer import ForceObserver
from hannes.bench.haptics import CHANNELS
from hannes.bench.live_run import LiveOrder, live, replayed
from hannes.bench.messages import State
from hannes.bench.profile_check import require_within
from hannes.bench.raw_log import FROM_BOARD, RawLogReader
from hannes.bench.reader import Link
from hannes.core.errors import BadInput, ComputationFailed
from hannes.core.recording.recording import Recording
from hannes.simulation.experiment.experiment import Reference

GRASP = """
title = "a soft cylinder, held"
hand = "hannes"
duration = "1.0 s"
sampling = "1 kHz"
[reference]
kind = "ramp"
points = [["0 s", "0 rad"], ["0.637 s", "9.84 rad"]]
[object]
shape = "cylinder"
material = { stiffness = "1500 N/m" }
"""


@pytest.fixture
def order(tmp_path):
    """A file of a grasp, and the order to close by it."""
    path = tmp_path / "grasp.toml"
    path.write_text(GRASP)
    (variant,) = load_experiment(path)
    return path, LiveOrder(variant)


@pytest.fixture
def boards(tmp_path):
    """Starts virtual boards in processes of their own; gives their addresses."""
    running = []

    def started(text):
        path = tmp_path / f"board{len(running)}.toml"
        path.write_text(text)
        command = [sys.executable, "-m", "hannes", "board", str(path), "--tcp", "0"]
        process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        running.append(process)
        return process.stdout.readline().strip()

    yield started
    for process in running:
        process.kill()
        process.wait()
        process.stdout.close()


def states(log):
    """States of the board in a raw log."""
    records = RawLogReader(log)
    listener = adapter(records.about["board"])
    found = [
        event.state
        for record in records.records()
        if record.direction == FROM_BOARD
        for event in listener.feed(record.data, 0.0)
        if isinstance(event, Status)
    ]
    records.close()
    return found


@pytest.mark.parametrize("observer", [None, ForceObserver], ids=["forests", "observer"])
def test_live_equals_the_raw_log_read_again(tmp_path, boards, order, model, observer, monkeypatch):
    monkeypatch.setattr("hannes.bench.live_run.BEHIND", 60.0)  # on a machine that does much else
    path, asked = order
    asked = replace(asked, observer=observer, seconds=2.0)
    sent = []
    log = tmp_path / "live.rawlog"
    link = Link(boards(f'experiment = "{path}"\n'))
    made = list(live(link, model, log, replace(asked, tactor=sent.append)))
    again = list(replayed(log, model, observer=observer() if observer else None))
    decided = [m for m in made if m.decision]
    assert len(decided) > 10
    for first, second in zip(made, again, strict=False):
        assert (first.time, first.values, first.decision) == (
            second.time,
            second.values,
            second.decision,
        )
        assert (first.force, first.haptic) == (second.force, second.haptic)
    assert observer is None or any(m.force.residual > 0.0 for m in made if m.force)
    assert decided[-1].decision.word in ("soft", "rigid", "don't know")
    assert sent[-1] == (0.0, 0.0, 0.0)
    assert len(sent) - 1 == sum(m.haptic is not None for m in made)
    assert states(log)[-1] is State.STOPPED


def test_an_iteration_that_is_left_stops_the_board(tmp_path, boards, order, model):
    path, asked = order
    log = tmp_path / "live.rawlog"
    asked = replace(asked, seconds=30.0)
    moments = live(Link(boards(f'experiment = "{path}"\n')), model, log, asked)
    while next(moments).values["reference"] < 1.0:  # until it follows
        pass
    moments.close()
    found = states(log)
    assert State.FOLLOWING in found
    assert found[-1] is State.STOPPED


def test_an_exception_stops_the_board(tmp_path, boards, order, model):
    path, asked = order
    log = tmp_path / "live.rawlog"

    def broken(command):
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        for _ in live(
            Link(boards(f'experiment = "{path}"\n')), model, log, replace(asked, tactor=broken)
        ):
            pass
    assert states(log)[-1] is State.STOPPED


def test_a_lost_link_ends_the_grasp_in_words(tmp_path, boards, order, model):
    path, asked = order
    address = boards(f'experiment = "{path}"\n[misbehaviour]\ncut = "4 s"\n')
    asked = replace(asked, seconds=30.0)
    with pytest.raises(ComputationFailed, match=r"link was lost|watchdog"):
        for _ in live(Link(address), model, tmp_path / "lost.rawlog", asked):
            pass


def test_ctrl_c_stops_the_board(tmp_path, boards, order, model_path):
    path, _ = order
    address, out = boards(f'experiment = "{path}"\n'), tmp_path / "grasp.h5"
    command = [sys.executable, "-m", "hannes", "live", address, str(model_path)]
    command += ["--close", str(path), "--seconds", "60", "--out", str(out), "--no-observer"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    process.stdout.readline()  # it is under way
    process.send_signal(signal.SIGINT)
    _, said = process.communicate(timeout=60.0)
    assert process.returncode not in (0, 1), said
    assert "Traceback" not in said
    assert states(f"{out}.rawlog")[-1] is State.STOPPED
    assert Recording.read(out).time.size > 10


def test_a_grasp_by_the_command_line_has_its_haptic_signal(tmp_path, boards, order, model_path):
    path, _ = order
    address, out = boards(f'experiment = "{path}"\n'), tmp_path / "grasp.h5"
    tactor, device = pty.openpty()
    tty.setraw(device)
    os.set_blocking(tactor, False)
    command = [sys.executable, "-m", "hannes", "live", address, str(model_path)]
    command += [
        "--close",
        str(path),
        "--out",
        str(out),
        "--haptics",
        os.ttyname(device),
        "--no-observer",
    ]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120.0, check=False)
    assert done.returncode == 0, done.stderr
    assert "P(rigid)" in done.stdout
    made = Recording.read(out)
    assert set(CHANNELS) <= set(made)
    assert made["vibration_amplitude"].max() == pytest.approx(1.0)
    lines = os.read(tactor, 1 << 16).decode().splitlines()
    assert lines[-1] == "h 0.000 0 0.000"
    assert len(lines) > 5
    (asked,) = load_experiment(path)
    plain = np.interp(made.time, *asked.experiment.reference.knots)
    assert np.abs(made["reference"] - plain).max() > 0.1  # the policy steered it
    assert made["reference"].max() < 1.07 * plain.max()
    for end in (tactor, device):
        os.close(end)


def test_a_command_beyond_the_limits_is_refused_before_it_is_sent(order, tmp_path, model):
    _, asked = order
    far = replace(asked.variant.experiment, reference=Reference([[0.0, 0.5], [0.0, 60.0]]))
    beyond = replace(asked, variant=replace(asked.variant, experiment=far))
    with pytest.raises(BadInput, match=r"60 rad.*Nothing was sent"):
        list(live(Link("/dev/no-such-port"), model, tmp_path / "x.rawlog", beyond))


def test_current_in_simulation_is_held_against_the_limit(order):
    experiment = order[1].variant.experiment
    require_within(Hand(), experiment)
    with pytest.raises(BadInput, match="current reaches"):
        require_within(Hand(), experiment, Limits(current=0.5))


def test_a_recording_is_silent_before_the_first_haptic_command():
    from hannes.bench.haptics import channels

    made = channels([(2.0, 0.5, 80.0, 0.25)], np.array([1.0, 2.0, 3.0]))
    assert made["vibration_amplitude"][1].tolist() == [0.0, 0.5, 0.5]
    assert made["vibration_frequency"][0] == "Hz"
    assert time.monotonic() > 0.0
