"""Test vectors of an exported model: drawn grasps, and what Python says of them.

The grasps are plain sums and products of numbers from a linear congruential generator, the same
here and in C (firmware/parts/self_test.c), so that a vector is a seed and what must come out.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from hannes.bench.c_tables import number
from hannes.recognition.model import (
    SINCE,
    Estimate,
    Model,
    decided,
    grasp_peak,
    grasp_stiffness,
    held,
    running,
)

SAMPLES, SEEDS = 1100, range(1, 9)
WORD = (1 << 64) - 1
OFFSET, PRIME = 14695981039346656037, 1099511628211  # of the 64-bit FNV-1a hash


@dataclass(frozen=True)
class Windows:
    """What is said live at the end of each window of a grasp.

    rows: features, float32 (n, features); window: probability of rigid of the window alone; rigid:
    of the grasp so far; words: SOFT, RIGID or UNKNOWN; holds: whether an object is held; all (n,).
    """

    rows: np.ndarray
    window: np.ndarray
    rigid: np.ndarray
    words: np.ndarray
    holds: np.ndarray


def windows(model: Model, samples: np.ndarray) -> Windows:
    """What is said live of samples (n, 3) of current [A], position and reference [rad]."""
    rows = model.windowing.features(samples[np.newaxis])[0]
    holds, window = held(rows), model.windows(rows)
    so_far = running(window, rows[:, SINCE] > 0.0, model.windowing.hop)
    rigid = np.where(np.logical_or.accumulate(holds), so_far, 0.5)
    return Windows(rows, window, rigid, decided(rigid, model.sure), holds)


def last_estimates(model: Model, said: Windows) -> tuple[Estimate | None, Estimate | None]:
    """Stiffness [N/m] at the end of a grasp, and force [N] at its last window with an object."""
    if not said.holds.any():
        return None, None
    value, apart = grasp_stiffness(model.stiffness.quantiles(said.rows[said.holds]))
    most, spread = grasp_peak(model.force.quantiles(said.rows[said.holds][-1:])[0])
    return (
        Estimate(value, *model.stiffness_band(value, apart)),
        Estimate(most, *model.force_band(most, spread)),
    )


def vectors(model: Model) -> str:
    """The test vectors as C."""
    lines = [
        "struct HannesVector {",
        "    uint32_t seed;",
        "    uint64_t hash; /* of features and probabilities, FNV-1a */",
        "    const char *words;",
        "    double stiffness[3], force[3];",
        "};",
        "#ifdef HANNES_SELF_TEST",
        "static const struct HannesVector hannes_vectors[] = {",
    ]
    lines += [_vector(model, seed) for seed in SEEDS]
    return "\n".join([*lines, "};", "#endif"]) + "\n"


def _vector(model: Model, seed: int) -> str:
    samples = drawn(seed, SAMPLES, 1.0 / model.windowing.sampling)
    said = windows(model, samples)
    words = "".join(map(str, said.words))
    ends = ", ".join(_triple(each) for each in last_estimates(model, said))
    return f'{{{seed}u, 0x{fingerprint(said):016x}u, "{words}", {ends}}},'


def _triple(estimate: Estimate | None) -> str:
    values = (estimate.value, estimate.low, estimate.high) if estimate else (0.0, 0.0, 0.0)
    return "{" + ", ".join(map(number, values)) + "}"


def fingerprint(said: Windows) -> int:
    """Hash of the bits of all features and of the windows' probabilities, in their order."""
    found = OFFSET
    for row, probability in zip(said.rows, said.window, strict=True):
        plus_zero = row.astype("<f4") + np.float32(0.0)  # one zero, whatever its sign
        for byte in plus_zero.tobytes() + np.float64(probability).astype("<f8").tobytes():
            found = (found ^ byte) * PRIME & WORD
    return found


def drawn(seed: int, count: int, period: float) -> np.ndarray:
    """A closure over something of a drawn place and stiffness, shape (count, 3), as in C."""
    chance = _chance(seed)
    free = 0.2 + 0.2 * next(chance)
    place = 2.0 + 6.0 * next(chance)
    slope = next(chance)
    slope = 0.05 + 2.0 * slope * slope
    shaft, samples = 0.0, np.empty((count, 3))
    for k in range(count):
        since = k * period
        asked = max(min(15.4 * since, 25.6 * (1.022 - since)), 0.0)
        squeeze = max(shaft - place, 0.0)
        shaft += 0.06 * (asked - shaft) / (1.0 + slope * squeeze)
        friction = free if asked >= shaft else -0.5 * free
        samples[k] = friction + slope * squeeze + 0.02 * (next(chance) - 0.5), shaft, asked
    return samples


def _chance(seed: int) -> Iterator[float]:
    """Numbers from 0 to 1 in steps of 2^-16 (Numerical Recipes' generator)."""
    while True:
        seed = (seed * 1664525 + 1013904223) & 0xFFFFFFFF
        yield (seed >> 16) / 65536.0
