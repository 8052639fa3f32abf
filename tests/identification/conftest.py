"""What several tests of the diagnosis look at."""

import pytest
from sled import investigation


@pytest.fixture
def investigated():
    return investigation()
