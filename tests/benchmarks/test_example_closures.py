"""The recordings of examples/closures are what the command beside them makes."""

from pathlib import Path

import numpy as np
import pytest

from benchmarks.truth.closures import main
from hannes.core.recording.recording import Recording

EXAMPLE = Path(__file__).parents[2] / "examples" / "closures"


@pytest.fixture(scope="module")
def again(tmp_path_factory):
    folder = tmp_path_factory.mktemp("closures")
    assert main(["--out", str(folder), "--slack", "3 mm", "--runs", "6", "--seed", "1"]) == 0
    return folder


def test_recordings_are_those_of_the_command_but_for_rounding(again):
    for file in sorted(EXAMPLE.glob("*.csv")):
        shipped, made = Recording.read(file), Recording.read(again / file.name)
        assert set(shipped) == set(made)
        for name in shipped:
            np.testing.assert_allclose(shipped[name], made[name], rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize("name", ["campaign.toml", "closure.toml", "hand.toml"])
def test_what_stands_beside_them_is_that_too(again, name):
    assert (EXAMPLE / name).read_text() == (again / name).read_text()
