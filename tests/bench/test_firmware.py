"""The reference firmware, compiled as a host program: the same bytes as the rules in Python."""

import random
import shutil
import struct
import subprocess
from pathlib import Path

import numpy as np
import pytest
from drawn_model import drawn_model
from toy_machine import Lag

import hannes.bench
from hannes.bench.adapters.framed import Framed
from hannes.bench.board_logic import HOST_LENGTHS, BoardLogic, Settings
from hannes.bench.events import About, Row, Status
from hannes.bench.export_c import export_c
from hannes.bench.frames import Splitter, encode
from hannes.bench.grip_loop import GripLoop
from hannes.bench.messages import State

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
    """A word to the host program: 1 ticks, 2 a grasp to so many mrad, 3 the object's mA/rad."""
    return struct.pack("<BH", what, round(count))


def run_alone(program, grasps):
    """Host and cable are there for a moment, then never again; a switch asks for each of `grasps`.

    A grasp: goal [rad], slope of the object [A/rad], ticks. Returns telemetry (n, 3) of reference,
    position and current, and the states that were said.
    """
    host = Framed()
    hello = b"".join((host.ask(), host.alive(1)))
    given = word(0, len(hello)) + hello + word(1, 10)
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
