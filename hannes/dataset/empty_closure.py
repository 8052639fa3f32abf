"""What an empty closure shows of a hand: means of current and lag over its phases.

A hand that closes and opens on nothing shows its slack, its gear's loss, its friction and its
motor's constant, which differ from hand to hand. Data sets have these means for each hand, and a
board's recording gives the same, summed in the same order as in C (`hannes export-c`).
"""

from pathlib import Path

import numpy as np

from hannes.core.io.toml_table import Table
from hannes.core.kernels.jit import entry
from hannes.simulation.experiment.experiment import Reference
from hannes.simulation.experiment.reader import read_reference

MEAN = 0.02  # s of one mean
STORED = "<f4"
LONGEST = 10.0  # s of an empty closure


def read_empty(root: Table, folder: Path | None, sampling: float) -> Reference | None:
    """The command of empty closures in a specification's table `empty`, None where there is none.

    It ends with its last point. Raises BadInput where that is too late, or no whole number of
    samples at `sampling` [Hz] makes a mean.
    """
    if "empty" not in root:
        return None
    command = read_reference(root, folder, "empty")
    if not command.kinked:
        root.refuse("empty", "is a ramp or steps, not of a file")
    if not MEAN <= command.knots[0, -1] <= LONGEST or not mean_size(sampling):
        root.refuse(
            "empty", f"= expected {MEAN:g} to {LONGEST:g} s, at whole samples in {MEAN:g} s"
        )
    return command


@entry
def _fill(current, lag, size, out):
    """Means of `size` samples of current, then those of lag, one after the other."""
    count = out.size // 2
    for k in range(count):
        sums = np.zeros(2)
        for n in range(k * size, (k + 1) * size):
            sums[0] += current[n]
            sums[1] += lag[n]
        out[k], out[count + k] = sums[0] / size, sums[1] / size


def mean_size(sampling: float) -> int:
    """Samples of a mean at `sampling` [Hz]; 0 where no whole number of them fills one."""
    size = round(MEAN * sampling)
    return size if size and abs(size / sampling - MEAN) < 1e-9 else 0


def numbers_of(command: Reference) -> int:
    """Numbers that an empty closure by a command has: a mean of each of the two every MEAN."""
    return 2 * int(command.knots[0, -1] / MEAN + 1e-6)


def empty_means(
    current: np.ndarray, position: np.ndarray, reference: np.ndarray, size: int, numbers: int
) -> np.ndarray:
    """Means (numbers,) of current [A], then of the lag of position behind reference [rad].

    The samples (n,) begin with the command; `size` of them make a mean. There must be
    `numbers` / 2 times as many.
    """
    out = np.zeros(numbers)
    lag = np.ascontiguousarray(reference - position)
    _fill(np.ascontiguousarray(current), lag, size, out)
    return out
