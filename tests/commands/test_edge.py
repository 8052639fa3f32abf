"""However a command ends it says so in one line: bad names, closed or full output, signals."""

import io
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from hannes.commands.cli import main
from hannes.commands.edge import INTERRUPTED, guarded

RAMP = '[reference]\nkind = "ramp"\npoints = [["0 s", "0 rad"], ["1 s", "15 rad"]]\n'
SHORT = 'duration = "20 ms"\n' + RAMP
ROW = '[[recording]]\nfile = "r.csv"\n'
LONG = "x" * 300


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("r.csv").write_text("time_s,current_A,reference_rad\n0,1,0\n0.1,2,0\n0.2,3,0\n")
    Path("log.csv").write_text("t,i\n0,1\n0.1,2\n")


@pytest.mark.parametrize(
    "arguments",
    [
        ["run", f"{LONG}.toml"],
        ["diagnose", f"{LONG}.toml"],
        ["check", f"{LONG}.csv"],
        ["check", f"{LONG}.h5"],
        ["check", f"{LONG}.mat"],
        ["check", LONG],
        ["hand", f"{LONG}.toml"],
        ["effects", f"{LONG}.py:X"],
        ["train", f"{LONG}.h5"],
        ["evaluate", f"{LONG}.h5", "r.csv"],
        ["convert", f"{LONG}.csv", "--mapping", "r.csv", "--out", "x.h5"],
        ["convert", "log.csv", "--mapping", f"{LONG}.toml", "--out", "x.h5"],
        ["reproduce", "--slack", LONG],
        ["check", "nul\0.csv"],
        ["run", "nul\0.toml"],
        ["trust", "nul\0.toml"],
        ["trust", f"{LONG}.toml"],
        ["trust", "."],
    ],
)
def test_names_that_no_file_can_have_are_one_line(capsys, arguments):
    assert main(arguments) == 2
    printed = capsys.readouterr()
    assert printed.out == "" and printed.err.count("\n") == 1 and printed.err.isprintable() is False


@pytest.mark.parametrize(
    "text",
    [
        'effects = ["a\\u0000b.py:X"]\n' + ROW,
        'effects = ["a\\u0000b"]\n' + ROW,
        f'effects = ["{LONG}.py:X"]\n' + ROW,
        f'base = "{LONG}.toml"\n' + ROW,
        f'[[recording]]\nfile = "{LONG}.csv"\n',
        f'[[recording]]\nfile = "{LONG}*.csv"\n',
        f'{ROW}experiment = "{LONG}.toml"\n',
        f'{ROW}runs = "{"1" * 5000}:"\n',
        f'{ROW}runs = "::{"0" * 5000}"\n',
        f'plant = "{LONG}:X"\n' + ROW,
        f'plant = "{LONG}"\n' + ROW,
    ],
)
def test_a_campaign_with_impossible_names_is_one_line(capsys, text):
    Path("c.toml").write_text(text)
    for verb in ("diagnose", "calibrate", "check"):
        assert main([verb, "c.toml", *["--trust"] * (verb != "x")]) == 2
        printed = capsys.readouterr()
        assert printed.out == "" and printed.err.count("\n") == 1 and len(printed.err) < 2000
    assert main(["trust", "c.toml"]) in (0, 2)


def test_a_title_with_dollars_is_drawn_as_it_is():
    from hannes.report import style

    with style.styled():
        figure, _ = style.panels(1, 1.6)
        figure.suptitle("50 $ of \\frac{ $ and $x")
        assert "50 $ of" in style.svg(figure, "dollars")


def command(*arguments, shell="", **how):
    """A process of its own; `shell` comes after the command."""
    words = " ".join([sys.executable, "-m", "hannes", *arguments, shell])
    return subprocess.run(words, shell=True, capture_output=True, text=True, check=False, **how)


@pytest.mark.skipif(os.name == "nt", reason="needs a POSIX shell")
def test_closed_or_full_standard_output_is_no_traceback():
    assert command("experiments", shell=">&-").returncode == 0
    assert command("experiments", shell=">&- 2>&- <&-").returncode == 0
    if Path("/dev/full").exists():
        done = command("experiments", shell="> /dev/full")
        assert done.returncode == 2 and done.stderr.count("\n") == 1
        assert "cannot write to standard output: No space left" in done.stderr
        assert command("experimints", shell="2> /dev/full").returncode == 2


SLOW = """
import sys, time
from hannes.commands import cli, run
run.observe = lambda *_: (print("at work", flush=True), time.sleep(60))
sys.exit(cli.main(["run", "short.toml", "--out", "out"]))
"""


@pytest.mark.skipif(os.name == "nt", reason="needs signals")
@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM", "SIGHUP"])
def test_signals_end_a_command_as_ctrl_c_does(name):
    Path("short.toml").write_text(SHORT)
    run = subprocess.Popen(
        [sys.executable, "-c", SLOW], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert run.stdout is not None and run.stdout.readline() == "at work\n"
    run.send_signal(getattr(signal, name))
    _, printed = run.communicate(timeout=10)
    assert run.returncode == INTERRUPTED
    (line,) = [each for each in printed.splitlines() if "compiling" not in each]
    assert line == "hannes: interrupted; earlier results are as they were"
    assert sorted(os.listdir()) == ["log.csv", "r.csv", "short.toml"]


WORKER = """
import multiprocessing, os, time
from hannes.core.io.parent import end_with
def work(parent):
    end_with(parent)
    print(os.getpid(), flush=True)
    time.sleep(60)
if __name__ == "__main__":
    child = multiprocessing.get_context("spawn").Process(target=work, args=(os.getpid(),))
    child.start()
    child.join()
"""


@pytest.mark.skipif(os.name == "nt", reason="needs SIGKILL")
def test_a_worker_ends_within_two_seconds_of_its_killed_parent():
    Path("parent.py").write_text(WORKER)
    parent = subprocess.Popen([sys.executable, "parent.py"], stdout=subprocess.PIPE, text=True)
    assert parent.stdout is not None
    worker = int(parent.stdout.readline())
    parent.kill()
    parent.wait()
    end = time.monotonic() + 2.0
    while time.monotonic() < end and _lives(worker):
        time.sleep(0.05)
    parent.stdout.close()
    assert not _lives(worker)


def _lives(number):
    try:
        state = Path(f"/proc/{number}/stat").read_text().rpartition(")")[2].split()[0]
    except OSError:
        return Path("/proc").exists() is False and _answers(number)
    return state != "Z"


def _answers(number):
    try:
        os.kill(number, 0)
    except OSError:
        return False
    return True


def test_an_error_of_the_system_names_its_file(monkeypatch, capsys):
    from hannes.simulation.experiment import shipped

    def broken():
        raise PermissionError(13, "Permission denied", "/somewhere")

    monkeypatch.setattr(shipped, "names", broken)
    assert main(["experiments"]) == 2
    assert capsys.readouterr().err == "hannes: /somewhere: Permission denied\n"
    monkeypatch.setattr(shipped, "names", lambda: bytearray(-1) or (_ for _ in ()).throw(1))
    assert main(["experiments"]) == 70
    kept = re.search(r"details are in (\S+):", capsys.readouterr().err)
    assert kept is not None
    Path(kept[1]).unlink()


def test_letters_that_no_encoding_has_are_shown_as_codes(monkeypatch):
    memory = io.BytesIO()
    monkeypatch.setattr(sys, "stdout", io.TextIOWrapper(memory, encoding="utf-8"))
    assert guarded(lambda: print("a\ud83dé"), ["effects"]) == 0
    sys.stdout.flush()
    assert memory.getvalue() == "a\\ud83dé\n".encode()
