"""The hand's model as a board: a stepper with the bits of `simulate`, recorded through a port."""

import copy
import pickle
import threading
from dataclasses import replace

import numpy as np
import pytest

from hannes import Hand, load_experiment, simulate
from hannes.bench.board_logic import Settings
from hannes.bench.misbehaviour import Misbehaviour
from hannes.bench.reader import Link
from hannes.bench.record import record, recover
from hannes.bench.virtual_board import Terminal, VirtualBoard
from hannes.bench.virtual_hand import VirtualHand
from hannes.core.recording.recording import Recording
from hannes.simulation.stepper import start


@pytest.fixture(scope="module")
def sampled():
    (variant,) = load_experiment("dynamometer")
    return replace(variant.experiment, controller="sampled", duration=0.4)


@pytest.fixture(scope="module")
def trajectory(sampled):
    return simulate(Hand(), sampled, rtol=1e-3).require()


def test_a_stepper_has_the_bits_of_simulate(sampled, trajectory):
    stepper = start(Hand(), sampled, rtol=1e-3)
    rows = [stepper.step() for _ in range(trajectory.time.size - 1)]
    for name in ("reference", "position", "current", "duty", "force", "leader_tension"):
        assert np.array_equal([row[name] for row in rows], trajectory[name][:-1]), name


def test_set_points_of_the_same_reference_give_the_same_motion(sampled, trajectory):
    stepper = start(Hand(), sampled, rtol=1e-3)
    rows = [stepper.step(float(r)) for r in trajectory["reference"][:200]]
    # A sample's time is off its tick's by a rounding, and so is its reference.
    assert [r["position"] for r in rows] == pytest.approx(trajectory["position"][:200], abs=1e-9)


@pytest.mark.parametrize("again", [copy.copy, lambda s: pickle.loads(pickle.dumps(s))])
def test_a_copy_goes_its_own_way(sampled, again):
    stepper = start(Hand(), sampled, rtol=1e-3)
    for _ in range(50):
        stepper.step()
    other = again(stepper)
    first = [stepper.step()["position"] for _ in range(20)]
    assert [other.step()["position"] for _ in range(20)] == first


def test_an_open_drive_gives_no_current(sampled):
    machine = VirtualHand(Hand(), replace(sampled, noise={}))
    for _ in range(200):
        closing = machine.step(5.0)
    for _ in range(200):
        after = machine.step(None)
    assert closing["current"] > 0.1
    assert abs(after["current"]) < 0.02


def test_an_experiment_recorded_from_a_board_is_the_simulation(tmp_path, sampled):
    (tmp_path / "short.toml").write_text(
        'title = "short"\nhand = "hannes"\nduration = "0.3 s"\nsampling = "1 kHz"\n'
        '[reference]\nkind = "ramp"\npoints = [["0 s", "0.3 rad"], ["0.3 s", "3 rad"]]\n'
    )
    (variant,) = load_experiment(tmp_path / "short.toml")
    quiet = replace(variant.experiment, noise={})

    def make():
        return VirtualHand(Hand(), quiet)

    make().step(None)
    board, over = VirtualBoard(make, Terminal(), Settings(), Misbehaviour()), threading.Event()
    thread = threading.Thread(target=board.run, args=(over.is_set,))
    thread.start()
    try:
        raw = tmp_path / "run.rawlog"
        done = record(str(tmp_path / "short.toml"), Link(board.far.address), raw)
    finally:
        over.set()
        thread.join()
        board.far.close()
    made = done.recording
    assert done.stopped
    assert made["reference"][0] == pytest.approx(0.3, abs=1e-6)
    assert np.interp(0.2, made.time, made["reference"]) == pytest.approx(2.1, abs=1e-5)
    made.write(tmp_path / "run.h5")
    assert Recording.read(tmp_path / "run.h5").experiment
    assert recover(raw) == made
