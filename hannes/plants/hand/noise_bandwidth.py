"""The bandwidth of the current sensor's noise, from what repeats of a command differ by.

A filter before the converter takes from white noise what is quick, and the rest counts for more in
the mean over some samples than the roughness of samples says. The loop colours noise as well. So
differences of two repeats are compared with those of two simulated runs, for noise of several
bandwidths: by how much second differences grow with the distance of their samples. What both
repeats do is in neither.
"""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from hannes.core.recording.recording import Recording
from hannes.core.recording.white_noise import roughness
from hannes.plants.hand.batch_runs import many, noise_columns, smoothness
from hannes.plants.hand.recorded_experiment import experiment_of
from hannes.simulation.hand.hand import Hand

WHITE = 0.0
BANDWIDTHS = (WHITE, 300.0, 210.0, 150.0, 110.0, 80.0, 60.0, 45.0, 34.0, 25.0)  # Hz
DISTANCES = (2, 3, 4)  # samples
KEPT = 0.9  # share of squared differences, the smallest: the others are of contacts
SCATTER = 0.1  # of the logarithm of their growth, in one pair of runs of USUAL samples
USUAL = 1300.0
CERTAIN = 12.0  # of chi-squared, that noise is not white
ALIKE = 2.5  # of chi-squared for a pair, at most: else what differs is not noise alone
FEWEST = 400  # samples
SIMULATED = 3  # runs with noise of each bandwidth


def noise_bandwidth(hand: Hand, repeats: Sequence[Sequence[Recording]]) -> float | None:
    """Bandwidth [Hz] of the noise in the current of these runs; 0 where it may be white.

    None where none of them show it. repeats: runs of each command
    """
    known = [
        (misfits, len(runs) - 1)
        for number, runs in enumerate(repeats)
        if _comparable(runs) and (misfits := _misfits(hand, runs, number)) is not None
    ]
    if not known:
        return None
    total = np.sum([misfits for misfits, _ in known], axis=0)
    best, pairs = int(np.argmin(total)), sum(count for _, count in known)
    coloured = total[0] - total[best] > CERTAIN and total[best] < ALIKE * pairs
    return BANDWIDTHS[best] if coloured else WHITE


def _comparable(runs: Sequence[Recording]) -> bool:
    """Whether these are repeats of a sampled controller with noise in their currents."""
    if len(runs) < 2 or any("current" not in each for each in runs):
        return False
    if min(each.time.size for each in runs) < FEWEST:
        return False
    return experiment_of(runs[0]).controller == "sampled" and roughness(runs[0]["current"]) > 0.0


def _misfits(hand: Hand, runs: Sequence[Recording], number: int) -> np.ndarray | None:
    """Chi-squared of the growth in pairs of repeats, for each bandwidth; None if a run fails."""
    currents = [each["current"] for each in runs]
    recorded = np.array([_growth(*pair) for pair in pairwise(currents)])
    scatter = SCATTER * np.sqrt(USUAL / min(each.size for each in currents))
    levels = [roughness(currents[0]) / smoothness(each, runs[0]) for each in BANDWIDTHS]
    columns = noise_columns(
        np.repeat(levels, SIMULATED),
        np.repeat(BANDWIDTHS, SIMULATED),
        1 + number * len(BANDWIDTHS) * SIMULATED,
    )
    made = many(hand, experiment_of(runs[0]), runs[0], columns, ("current",), True)
    drawn = [each["current"] for each in made if each is not None]
    if len(drawn) < len(made):
        return None
    grown = np.array([_growth(*pair) for pair in pairwise(drawn)])
    own = [slice(k, k + SIMULATED - 1) for k in range(0, len(drawn), SIMULATED)]
    off = np.array([recorded - np.mean(grown[each], axis=0) for each in own]) / scatter
    return np.asarray(np.sum(off**2, axis=(1, 2)) / len(DISTANCES))


def _growth(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Logarithm of how second differences of the noise grow with the distance of samples."""
    size = min(one.size, other.size)
    apart = one[:size] - other[:size]
    first, *more = (_mean_square(apart, distance) for distance in (1, *DISTANCES))
    return np.log(np.maximum(more, 1e-30) / max(first, 1e-30))


def _mean_square(values: np.ndarray, distance: int) -> float:
    """Mean square of second differences of samples that far apart, without the largest."""
    second = values[2 * distance :] - 2.0 * values[distance:-distance] + values[: -2 * distance]
    squares = np.sort(second**2)
    return float(np.mean(squares[: int(KEPT * squares.size)]))
