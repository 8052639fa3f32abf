"""What all tests share."""

import os
import signal
from pathlib import Path

import pytest
from hypothesis import settings

# There is a worker on each core: further threads of the linear algebra would only wait beside it,
# and they wait by spinning. numpy reads this when it is first imported: here nothing may before.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

# A shell's background jobs start with Ctrl-C ignored, and so would all that they start.
signal.signal(signal.SIGINT, signal.default_int_handler)

# A first call compiles, which says nothing about the function.
settings.register_profile("compiled", deadline=None)
settings.load_profile("compiled")


@pytest.fixture(autouse=True, scope="session")
def unflushed():
    """Files of tests need not survive a power cut: the disk took a tenth of the time."""
    from hannes.core.io import atomic_files

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(atomic_files, "_flush", lambda path: None)
        yield


@pytest.fixture(scope="session")
def compiling():
    """For tests of compiled code, which there is none of with NUMBA_DISABLE_JIT."""
    from hannes.core.kernels.jit import compiles

    if not compiles():
        pytest.skip("nothing is compiled here")


@pytest.fixture
def investigated():
    """What an investigation of a sled finds in which turbulence is hidden; made once a process."""
    from sled import investigation

    return investigation()


# Each file goes to one worker, in this order: a model is compiled by one of them, once, and the
# longest do not end alone. The first ones need different models, or none; others find them made.
FIRST = (
    "simulation/test_batch.py",
    "benchmarks/test_truth_effects.py",
    "simulation/test_catalogue.py",
    "simulation/test_floating_object.py",
    "simulation/test_assemble.py",
    "docs/test_blocks.py",
    "bench/test_force_observer.py",
    "identification/test_fits.py",
    "identification/test_decision.py",
    "identification/test_diagnosis.py",
    "identification/test_axis_diagnosis.py",
    "benchmarks/test_mujoco.py",
    "simulation/test_rodas.py",
)


def pytest_collection_modifyitems(items):
    """Files in the order of FIRST, those with slow tests next, then all others."""
    order = {Path(__file__).parent / name: place for place, name in enumerate(FIRST)}
    slow = {item.path for item in items if item.get_closest_marker("slow")}
    items.sort(key=lambda item: (order.get(item.path, len(order)), item.path not in slow))
