"""Machine code: made of what Python calls, and of nothing else; settings of numba as they were."""

import gc
import importlib.util

import pytest

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
