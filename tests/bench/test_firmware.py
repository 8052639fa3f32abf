"""The reference firmware, compiled as a host program: the same bytes as the rules in Python."""

import random
import shutil
import struct
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from drawn_model import NUMBERS, drawn_model
from toy_machine import Lag

import hannes.bench
from hannes import load_experiment
from hannes.bench.adapters.framed import Framed
from hannes.bench.board_logic import HOST_LENGTHS, BoardLogic, Settings
from hannes.bench.events import About, Row, Status
from hannes.bench.export_c import export_c
from hannes.bench.frames import Splitter, encode
from hannes.bench.grip_loop import GripLoop
from hannes.bench.messages import State
from hannes.dataset.empty_closure import empty_means

SOURCE = Path(hannes.bench.__file__).parent / "firmware" / "hannes_board.c"
COMPILER = shutil.which("cc") or shutil.which("gcc")


@pytest.fixture(scope="module")
def firmware(tmp_path_factory):
    if COMPILER is None:
        pytest.skip("no C compiler on this machine")
    made = tmp_path_factory.mktemp("firmware") / "board"
    flags = ["-std=c99", "-O1", "-Wall", "-Wextra", "-Werror", "-ffp-contract=off"]
    subprocess.run([COMPILER, *flags, "-DHANNES_HOST", SOURCE, "-o", made], check=True)
    return made


def script(seed: int):
    """Bytes and ticks in turn: requests of all kinds, some damaged, some out of order."""
    chance, host = random.Random(seed), Framed()
    profile = [(0.01 * k, chance.uniform(-0.5, 2.0)) for k in range(chance.randrange(2, 30))]
    requests = [host.ask(), *host.profile(profile), host.start()]
    for _ in range(60):
        makers = (
            lambda: host.alive(chance.randrange(1000)),
            lambda: host.set_point(chance.uniform(-2.0, 8.0)),
            lambda: host.resend(chance.randrange(400), chance.randrange(60)),
            lambda: host.start(),
            lambda: host.stop(),
            lambda: bytes(chance.randrange(256) for _ in range(chance.randrange(1, 400))) + b"\0",
        )
        requests.append(chance.choice(makers)())
    for packet in requests:
        yield 0, packet
        yield 1, chance.choice((1, 3, 20, 250))


def of_python(steps) -> bytes:
    board = BoardLogic(Lag(), Settings(firmware="hannes reference 1", ring=256))
    splitter, out, damaged = Splitter(HOST_LENGTHS), b"", 0
    for what, content in steps:
        if what:
            frames = [frame for _ in range(content) for frame in board.tick()]
        else:
            heard, frames = splitter.feed(content), []
            board.damaged(splitter.damaged - damaged)
            damaged = splitter.damaged
            for frame in heard:
                frames += board.hear(frame)
        out += b"".join(map(encode, frames))
    return out


@pytest.mark.parametrize("seed", range(5))
def test_firmware_and_rules_say_the_same_bytes(firmware, seed):
    steps = list(script(seed))
    asked = b"".join(
        struct.pack("<BH", what, content if what else len(content)) + (b"" if what else content)
        for what, content in steps
    )
    said = subprocess.run([firmware], input=asked, capture_output=True, check=True).stdout
    assert said == of_python(steps)


# ---- a strategy of its own: recognition and grip policy, without a host --------------------------

GOAL, TICKS, PERIOD = 9.0, 1600, 1e-3


@pytest.fixture(scope="module")
def strategy(tmp_path_factory):
    """The firmware with an exported model linked in, and that model."""
    if COMPILER is None:
        pytest.skip("no C compiler on this machine")
    folder, model = tmp_path_factory.mktemp("strategy"), drawn_model()
    (folder / "recogniser.c").write_text(export_c(model).text)
    flags = ["-std=c99", "-O1", "-Wall", "-Wextra", "-Werror", "-Wno-unused-function"]
    flags += ["-ffp-contract=off", "-DHANNES_HOST", '-DHANNES_STRATEGY="recogniser.c"']
    command = [COMPILER, *flags, f"-I{folder}", SOURCE, "-o", folder / "board", "-lm"]
    subprocess.run(command, check=True)
    return folder / "board", model


def heard(said):
    """Events in what a board said."""
    speaker = Framed()
    return [e for packet in said.split(b"\0") for e in speaker.feed(packet + b"\0", 0.0)]


def word(what, count):
    """A word to the host program: 1 ticks, 2 a grasp to so many mrad, 3 the object's mA/rad, 4
    a closure on nothing."""
    return struct.pack("<BH", what, round(count))


def run_alone(program, grasps, before=b""):
    """Host and cable are there for a moment, then never again; a switch asks for each of `grasps`.

    A grasp: goal [rad], slope of the object [A/rad], ticks. `before`: words after the first ticks.
    Returns telemetry (n, 3) of reference, position and current, and the states that were said.
    """
    host = Framed()
    hello = b"".join((host.ask(), host.alive(1)))
    given = word(0, len(hello)) + hello + word(1, 10) + before
    for goal, slope, ticks in grasps:
        given += word(3, 1e3 * slope) + word(2, 1e3 * goal) + word(1, ticks)
    said = subprocess.run([program], input=given, capture_output=True, check=True)
    events = heard(said.stdout)
    rows = np.array([each.values for each in events if isinstance(each, Row)])
    return rows[10:], [each.state for each in events if isinstance(each, Status)]


def python_alone(model, grasps):
    """References of the same grasps by Python's loop, on the same machine; firm at each end."""
    loop, units = GripLoop(model), {"reference": "rad", "position": "rad", "current": "A"}
    loop.feed(About("x", units, 1000.0, 0.2), 0.0)
    shaft, command, reference, references, firm, k = 0.0, 0.0, 0.0, [], [], 0
    for goal, slope, ticks in grasps:
        for _ in range(ticks):
            squeeze = max(shaft - 4.0, 0.0)
            shaft += 0.06 * (reference - shaft - 0.8 * slope * squeeze)
            current = (0.25 if reference >= shaft else -0.125) + slope * squeeze
            references.append(reference)
            command = min(max(goal, command - 15.4 * PERIOD), command + 15.4 * PERIOD)
            loop.feed(Row(k, k * PERIOD, (reference, shaft, current)), command)
            reference, k = loop.set_point, k + 1
        firm.append(loop.firm)
    return np.array(references), firm


SOFT, RIGID, OPEN = (GOAL, 0.1, TICKS), (GOAL, 2.0, TICKS), (0.0, 0.0, 900)


@pytest.mark.parametrize("grasps", [
    [SOFT], [RIGID], [SOFT, OPEN, RIGID], [RIGID, OPEN, SOFT],
], ids=["soft", "rigid", "soft then rigid", "rigid then soft"])  # fmt: skip
def test_the_policy_runs_with_the_cable_out(strategy, grasps):
    program, model = strategy
    rows, states = run_alone(program, grasps)
    assert set(states[2:]) == {State.FOLLOWING}  # no watchdog: nobody leads but the board itself
    wanted, by_python = python_alone(model, grasps)
    firm = grasps[-1] is RIGID
    assert by_python[-1] is firm
    assert by_python[0] is (grasps[0] is RIGID)
    assert rows[:, 0] == pytest.approx(wanted[: len(rows)], abs=1.1e-6)  # telemetry's step
    squeezed = rows[-1, 0] - 4.0
    assert squeezed == pytest.approx(5.0, abs=0.01) if firm else squeezed < 0.7 * 5.0


def test_a_host_that_leads_is_still_watched(strategy):
    program, _ = strategy
    host = Framed()
    asked = host.ask() + host.set_point(1.0)
    given = struct.pack("<BH", 0, len(asked)) + asked + struct.pack("<BH", 1, 100)
    given += word(2, 9000) + word(1, 500)
    said = subprocess.run([program], input=given, capture_output=True, check=True).stdout
    events = heard(said)
    assert [each.state for each in events if isinstance(each, Status)][-1] is State.WATCHDOG
    assert max(each.values[0] for each in events if isinstance(each, Row)) == 1.0


def toy_closure():
    """Current, position and reference (n, 3) of the toy's closure on nothing, and where it ends."""
    times, angles = load_experiment("empty-closure")[0].experiment.reference.knots
    shaft, rows = 0.0, []
    for reference in np.interp(1e-3 * np.arange(round(1e3 * times[-1]) + 1), times, angles):
        shaft += 0.06 * (reference - shaft)
        rows.append((0.25 if reference >= shaft else -0.125, shaft, reference))
    return np.array(rows), shaft


def test_the_board_closes_on_nothing_by_itself(strategy):
    closure, _ = toy_closure()
    rows, states = run_alone(strategy[0], [], word(4, 0) + word(1, len(closure) + 120))
    assert rows[: len(closure), 0] == pytest.approx(closure[:, 2], abs=1.1e-6)
    assert State.FOLLOWING in states and states[-1] is State.IDLE


KNOWING = """
#include "hannes_board.c"
#include <stdio.h>
static double shaft, slope;
void hardware_send(const uint8_t *bytes, size_t count) { (void)bytes; (void)count; }
void hardware_step(bool open, double reference, double *values)
{
    double target = open ? shaft : reference, squeeze = shaft > 4.0 ? shaft - 4.0 : 0.0;
    shaft += 0.06 * (target - shaft - 0.8 * slope * squeeze);
    values[REFERENCE_CHANNEL] = target;
    values[POSITION_CHANNEL] = shaft;
    values[CURRENT_CHANNEL] = (open ? 0.0 : target >= shaft ? 0.25 : -0.125) + slope * squeeze;
}
int main(int count, char **words)
{
    static struct Board board;
    double flags[4];
    (void)words;
    board_init(&board);
    slope = count > 1 ? 0.6 : 0.0; /* something is held already */
    flags[0] = board_empty(&board);
    board_tick(&board);
    flags[1] = board_empty(&board) || board_grasp(&board, 9.0, 0.0); /* while it closes */
    for (int k = 0; k < 1700; k++) board_tick(&board);
    flags[2] = board.empty.known;
    slope = 0.6;
    board_grasp(&board, 9.0, 0.0);
    for (int k = 0; k < 1600; k++) board_tick(&board);
    board_stop(&board);
    flags[3] = board_empty(&board); /* half closed */
    fwrite(flags, 8, 4, stdout);
    fwrite(board.empty.point, 8, HANNES_HAND, stdout);
    fwrite(board.said.pressed, 8, 3, stdout);
    return 0;
}
"""


@pytest.fixture(scope="module")
def knowing(tmp_path_factory):
    """A program around the firmware, whose model knows the toy's hand and few others; the model."""
    folder, model = tmp_path_factory.mktemp("knowing"), drawn_model()
    points = model.pressed.points(empty_means(*toy_closure()[0].T, 20, NUMBERS))
    reach = np.array([1e3, *(1.001 * np.abs(points))])
    model = replace(model, pressed=replace(model.pressed, reach=reach))
    (folder / "recogniser.c").write_text(export_c(model).text)
    (folder / "own.c").write_text(KNOWING)
    flags = ["-std=c99", "-O1", "-Wall", "-Wextra", "-Werror", "-Wno-unused-function"]
    flags += ["-ffp-contract=off", '-DHANNES_STRATEGY="recogniser.c"']
    where = [f"-I{folder}", f"-I{SOURCE.parent}", folder / "own.c", "-o", folder / "own", "-lm"]
    subprocess.run([COMPILER, *flags, *where], check=True)
    return folder / "own", model


def pressed_alone(model, hand, shaft):
    """Stiffness by the traces [N/m] with its ends of the toy's grasp, by Python's loop."""
    loop, units = (
        GripLoop(model, hand=hand),
        {"reference": "rad", "position": "rad", "current": "A"},
    )
    loop.feed(About("x", units, 1000.0, 0.2), 0.0)
    command = reference = shaft
    found = None
    for k in range(1600):
        squeeze = max(shaft - 4.0, 0.0)
        shaft += 0.06 * (reference - shaft - 0.48 * squeeze)
        current = (0.25 if reference >= shaft else -0.125) + 0.6 * squeeze
        command = min(GOAL, command + 15.4 * PERIOD)
        for each in loop.feed(Row(k, k * PERIOD, (reference, shaft, current)), command).decisions:
            found = each.pressed or found
        reference = loop.set_point
    return list(vars(found).values())


def test_the_board_knows_its_hand_once_it_closed_on_nothing(strategy, knowing):
    program, model = knowing
    closure, shaft = toy_closure()
    numbers = empty_means(*closure.T, 20, NUMBERS)
    said = np.frombuffer(subprocess.run([program], capture_output=True, check=True).stdout)
    assert said[:4].tolist() == [1.0, 0.0, 1.0, 0.0]
    assert said[4:-3] == pytest.approx(model.pressed.points(numbers), rel=1e-9)
    wanted = pressed_alone(model, numbers, shaft)
    assert said[-3:] == pytest.approx(wanted, rel=1e-9)
    assert wanted != pytest.approx(pressed_alone(model, None, shaft), rel=1e-3)


def test_a_board_that_closed_on_something_knows_no_hand(strategy, knowing):
    program, model = knowing
    asked = [program, "held"]
    said = np.frombuffer(subprocess.run(asked, capture_output=True, check=True).stdout)
    assert said[:4].tolist() == [1.0, 0.0, 0.0, 0.0]
    wider = np.log(said[-1] / said[-2])
    assert wider == pytest.approx(2.0 * 1.96 * model.pressed.error[0])
