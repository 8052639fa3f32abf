"""A user's kernel that numba refuses: one line with file, kernel and reason, not a traceback."""

import re
import sys

import numpy as np
import pytest
from own_effect import EFFECT

from hannes.commands.cli import main

EXPERIMENT = """\
effects = ["mine.py:EFFECT"]
duration = "10 ms"
[reference]
kind = "ramp"
points = [["0 s", "0 rad"], ["1 s", "15 rad"]]
"""
CAMPAIGN = """\
plant = "axis"
effects = ["mine.py:EFFECT"]
[[recording]]
file = "run.csv"
"""
REFUSED = {
    "an undefined name": ("@kernel", "return size * nowhere * motor_speed", "'nowhere'"),
    "a function that is no kernel": ("", "return size * motor_speed", "Untyped global"),
    "a list without items": ("@kernel", "return size * len([])", "list"),
    "a Python-only statement": ("@kernel", 'with open("x"):\n        return size', "context"),
    "more values than channels": ("@kernel", "return size, motor_speed", "Tuple"),
}


@pytest.fixture(autouse=True)
def forgotten():
    """Own effects of other tests in this process are none of this one's."""
    for name in [each for each in sys.modules if each.startswith("hannes_own_")]:
        del sys.modules[name]


def with_effect(folder, fault, name, text):
    """A file that uses an effect with this fault."""
    mark, body, _ = REFUSED[fault]
    code = f"{mark}\ndef rub(motor_speed, size):\n    {body}\n"
    (folder / "mine.py").write_text(EFFECT.format(code=code), encoding="utf-8")
    (folder / name).write_text(text, encoding="utf-8")
    return str(folder / name)


def refused(folder, capsys, fault, *arguments):
    """Run a command that must end in the one line."""
    assert main([*arguments, "--trust", "--out", str(folder / "out")]) == 2
    printed = capsys.readouterr()
    lines = printed.err.splitlines()  # stages of the work among them
    (line,) = [each for each in lines if not re.match(r"diagnosing|hannes: compiling", each)]
    assert line.startswith(f"hannes: {folder / 'mine.py'}: kernel rub cannot be compiled: ")
    assert REFUSED[fault][2] in line and "Failed in" not in line
    assert printed.out == "" and not (folder / "out").exists()


@pytest.mark.slow
def test_run_reports_it_in_one_line(tmp_path, capsys):
    fault = "an undefined name"
    refused(tmp_path, capsys, fault, "run", with_effect(tmp_path, fault, "my.toml", EXPERIMENT))


@pytest.mark.parametrize("fault", REFUSED)
def test_diagnose_reports_it_in_one_line(tmp_path, capsys, fault):
    t = np.arange(0.0, 0.4, 1e-3)
    rows = np.column_stack([t, 0.1 * t**2, 0.099 * t**2, t])
    head = "time_s,reference_m,position_m,drive_V"
    np.savetxt(tmp_path / "run.csv", rows, delimiter=",", header=head, comments="")
    file = with_effect(tmp_path, fault, "campaign.toml", CAMPAIGN)
    refused(tmp_path, capsys, fault, "diagnose", file)


def test_numba_errors_that_are_nobodys_kernel_are_left_alone():
    from numba.core.errors import TypingError

    from hannes.simulation.compiler.kernel_error import blamed

    for error in (TypingError("in a kernel of nobody's"), ValueError("not numba's")):
        assert blamed(error) is None
