"""Machine code: made of what Python calls, and of nothing else; settings of numba as they were."""

import gc
import importlib.util
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from hannes.core.kernels import numba_private
from hannes.core.recording.recording import Recording
from hannes.plants.axis import slow_friction
from hannes.plants.axis.plant import Axis

HERE = Path(__file__).parent

SOURCE = """\
from hannes.core.kernels.jit import entry, routine


@routine
def doubled(x):
    if x < 0.0:
        raise ValueError("below 0")
    return 2.0 * x


@entry
def asked(x):
    return doubled(x) + 1.0
"""


@pytest.fixture
def module(tmp_path, compiling):
    """A module outside the package, whose machine code is kept beside it."""
    file = tmp_path / "asked_for.py"
    file.write_text(SOURCE)
    spec = importlib.util.spec_from_file_location("asked_for", file)
    found = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(found)
    return found


def test_machine_code_is_made_of_entry_points_alone(module):
    from numba.core.codegen import JITCodeLibrary
    from numba.core.registry import cpu_target

    assert module.asked(3.0) == 7.0
    with pytest.raises(ValueError, match="below 0"):
        module.asked(-1.0)
    codegen = cpu_target.target_context.codegen()
    made = {}
    for function in (module.asked, module.doubled):
        (overload,) = function.overloads.values()
        made[function.__name__] = overload.library.codegen is codegen
    assert made == {"asked": True, "doubled": False}
    assert codegen._library_class is JITCodeLibrary
    assert gc.isenabled()


def test_a_numba_that_lacks_a_private_part_compiles_the_same_numbers(compiling, tmp_path):
    """The axis plant in a process of its own whose numba lacks one: same bits, one warning."""
    lacking = "numba.core.codegen:JITCodeLibrary._renamed"
    script = (
        "from hannes.core.kernels import numba_private\n"
        f"numba_private.PARTS += ({lacking!r},)\n"
        "import sys, test_jit\n"
        "sys.stdout.buffer.write(test_jit.swing_of_the_axis())\n"
        "assert numba_private.options(forceinline=True) == {}\n"
    )
    environment = os.environ | {
        "HANNES_CACHE": str(tmp_path),
        "PYTHONPATH": os.pathsep.join(sys.path),
    }
    command = [sys.executable, "-W", "default", "-c", script]
    run = subprocess.run(command, cwd=HERE, env=environment, capture_output=True, check=True)
    assert run.stdout == swing_of_the_axis()
    assert run.stderr.decode().count(f"has no {lacking}") == 1
    assert numba_private.missing() == ""


def swing_of_the_axis() -> bytes:
    """Outputs of a simulated axis whose friction differs near standstill."""
    t = np.arange(1501) / 1000.0
    reference = 0.05 * (1.0 - np.cos(2.0 * np.pi * t))
    channels = {"time": t, "reference": reference, "position": reference}
    recording = Recording(channels, {"time": "s", "reference": "m", "position": "m"}, plant="axis")
    outputs = Axis((slow_friction.EFFECT,)).simulate({"slow_friction.force": 5.0}, recording)
    return b"".join(values.tobytes() for values in outputs.values())


@pytest.mark.parametrize("owner", ["PARTS", "OF_GENERATOR", "OF_LIBRARY"])
def test_a_private_part_that_is_gone_is_named(monkeypatch, owner):
    name = "numba.core.cpu:CPUTargetOptions._gone" if owner == "PARTS" else "_gone"
    monkeypatch.setattr(numba_private, owner, (*getattr(numba_private, owner), name))
    assert numba_private._missing().endswith("._gone")
