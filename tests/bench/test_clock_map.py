"""The map from the board's clock to the host's: late frames do not bend it."""

import numpy as np
import pytest

from hannes.bench.clock_map import clock_map


@pytest.mark.parametrize("drift", [40e-6, -0.004])
def test_delays_of_any_frames_do_not_bend_it(drift):
    board = 7.0 + np.arange(0.0, 10.0, 1e-3)
    late = np.random.default_rng(3).gamma(1.0, 2e-3, board.size)
    late[4000:6000] += 0.3  # a stall
    late[::500] = 0.0
    found = clock_map(board, 1000.0 + (1.0 + drift) * board + late)
    assert found.drift == pytest.approx(drift, abs=1e-9)
    assert found.host(board[0]) == pytest.approx(1000.0 + (1.0 + drift) * board[0], abs=1e-6)


def test_one_frame_says_the_offset_alone():
    found = clock_map(np.array([2.0]), np.array([5.0]))
    assert (found.offset, found.drift) == (3.0, 0.0)
