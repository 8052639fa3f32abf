"""What all tests share."""

import signal

import pytest
from hypothesis import settings

from hannes.core.kernels.jit import compiles

# A shell's background jobs start with Ctrl-C ignored, and so would all that they start.
signal.signal(signal.SIGINT, signal.default_int_handler)

# A first call compiles, which says nothing about the function.
settings.register_profile("compiled", deadline=None)
settings.load_profile("compiled")


@pytest.fixture(scope="session")
def compiling():
    """For tests of compiled code, which there is none of with NUMBA_DISABLE_JIT."""
    if not compiles():
        pytest.skip("nothing is compiled here")


def pytest_collection_modifyitems(items):
    """Files with slow tests first: each goes to one worker, and the last one would end alone."""
    slow = {item.path for item in items if item.get_closest_marker("slow")}
    items.sort(key=lambda item: item.path not in slow)
