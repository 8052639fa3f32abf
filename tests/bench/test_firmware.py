"""The reference firmware, compiled as a host program: the same bytes as the rules in Python."""

import random
import shutil
import struct
import subprocess
from pathlib import Path

import pytest
from toy_machine import Lag

import hannes.bench
from hannes.bench.adapters.framed import Framed
from hannes.bench.board_logic import HOST_LENGTHS, BoardLogic, Settings
from hannes.bench.frames import Splitter, encode

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
