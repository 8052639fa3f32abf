"""Stiffness of an object from the traces of a grasp that presses on it, once `AFTER` is over.

Trees see some features of a window. Near the border of soft and rigid these do not separate hand
and object. Small networks see what current and position did from the start of the motion until
0.62 s after the touch: the free closing shows the hand, the squeeze the object in it. They are
given what the hand showed while it closed on nothing, too, where that is known (known_hand.py).
Sums are taken in the same order in C (`hannes export-c`).
"""

from dataclasses import dataclass, fields

import numpy as np

from hannes.core.errors import BadInput
from hannes.core.kernels.jit import entry, kernel

BIN = 5e-3  # s, of which sums are kept
GROUP = 4  # bins of one mean
START = 12  # means from the start of the motion on
BEFORE, AFTER = 8, 31  # means before the touch, and after it
TRACE = BEFORE + AFTER
INPUTS = 3 * TRACE + 2 * START + 2
EARLIEST = GROUP * BEFORE + 1  # bin of the touch before which there is no estimate
LATEST = 240  # bin of the touch from which there is none
MOST_NETS, MOST_UNITS = 32, 512
MOST_NUMBERS = 1000  # of an empty closure
UNKNOWN, KNOWN = 0, 1  # place of the error of a hand that is not known, and of one that is
LARGEST = 1e9  # of a number in a model, which any real one stays far within


@entry
def inputs(current, position, reference, touch, dt, size, out):
    """Fill `out` (INPUTS,) from samples every `dt` [s]; `touch`: sample of it, bins of `size`.

    Means of current [A], travel from the touch and lag [rad] about the touch, of current and lag
    from the start on, position [rad] and time [s] of the touch.
    """
    first = (touch // size - GROUP * BEFORE) * size
    step = GROUP * size
    for g in range(TRACE + START):
        begin = first + g * step if g < TRACE else (g - TRACE) * step
        sums = np.zeros(3)
        for b in range(GROUP):
            part = np.zeros(3)
            for k in range(begin + b * size, begin + (b + 1) * size):
                part[0] += current[k]
                part[1] += position[k]
                part[2] += reference[k]
            for c in range(3):
                sums[c] += part[c]
        place, lag = sums[1] / step, sums[2] / step - sums[1] / step
        if g < TRACE:
            out[g] = sums[0] / step
            out[TRACE + g] = place - position[touch]
            out[2 * TRACE + g] = lag
        else:
            out[2 * TRACE + g] = sums[0] / step
            out[2 * TRACE + START + g] = lag
    out[INPUTS - 2], out[INPUTS - 1] = position[touch], touch * dt


@kernel
def _layer(weights, values, bounded):
    """Units with their constant in the last column; where bounded, none says less than zero."""
    out = np.zeros(weights.shape[0])
    for k in range(out.size):
        total = float(weights[k, values.size])
        for j in range(values.size):
            total += float(weights[k, j]) * values[j]
        out[k] = total if total > 0.0 or not bounded else 0.0
    return out


@kernel
def _mixed(mix, values, centre, out):
    """Fill the first of `out` with `mix` times the values less their centre; the farthest of it."""
    farthest = 0.0
    for k in range(mix.shape[0]):
        total = 0.0
        for j in range(values.size):
            total += float(mix[k, j]) * (values[j] - centre[j])
        out[k] = total
        farthest = max(farthest, abs(total)) if abs(total) < np.inf else np.inf
    return farthest


@entry
def _hand_points(mix, numbers, centre, reach, out):
    """Fill `out` with what the networks see of an empty closure; whether all is within `reach`."""
    _mixed(mix, numbers, centre, out)
    for k in range(out.size):
        if not abs(out[k]) <= reach[k]:
            return False
    return True


@entry
def _mean_of_networks(values, hand, centre, mix, first, second, last, reach):
    """Mean over networks for inputs `values`; NaN where they lie beyond what was learned from.

    hand: points of the hand, which follow those of the values.
    """
    point = np.zeros(mix.shape[0] + hand.size)
    if not _mixed(mix, values, centre, point) <= reach:
        return np.nan
    for k in range(hand.size):
        point[mix.shape[0] + k] = hand[k]
    total = 0.0
    for net in range(first.shape[0]):
        hidden = _layer(first[net], point, True)
        total += _layer(last[net], _layer(second[net], hidden, True), False)[0]
    return total / first.shape[0]


@dataclass(frozen=True)
class PressedStiffness:
    """Log stiffness [N/m] of a pressed object: the mean over networks of two hidden layers.

    `mix` (points, inputs) takes inputs less `centre` (inputs,) to points of some size 1, and
    `hand_mix` (hand points, numbers) those of an empty closure less `hand_centre` (numbers,): both
    have no numbers where none were learned from. The layers `first` (nets, units, all points + 1),
    `second` (nets, units, units + 1) and `last` (nets, 1, units + 1) have a unit's constant in the
    last column. `reach`: farthest that counts as learned from (1 + hand points,), of any point of
    traces, then of each of hands; `error`: standard deviation of the log stiffness near the border
    (2,), of hands UNKNOWN and KNOWN.
    """

    centre: np.ndarray
    mix: np.ndarray
    hand_centre: np.ndarray
    hand_mix: np.ndarray
    first: np.ndarray
    second: np.ndarray
    last: np.ndarray
    reach: np.ndarray
    error: np.ndarray

    def __call__(self, rows: np.ndarray, hand: np.ndarray | None = None) -> np.ndarray:
        """Log stiffness for rows of inputs (m, INPUTS), shape (m,); NaN where out of reach.

        hand: its `points`, None for one that is not known, which counts as the middle one.
        """
        points = np.zeros(self.hand_mix.shape[0]) if hand is None else hand
        arrays = (self.centre, self.mix, self.first, self.second, self.last, self.reach[0])
        return np.array([_mean_of_networks(row, points, *arrays) for row in rows])

    def points(self, numbers: np.ndarray) -> np.ndarray | None:
        """What the networks see of an empty closure's numbers; None where they are out of reach.

        Raises BadInput where they are not as many as were learned from.
        """
        if numbers.shape != self.hand_centre.shape:
            raise BadInput("these are no numbers of an empty closure that this model knows")
        out = np.zeros(self.hand_mix.shape[0])
        near = _hand_points(self.hand_mix, numbers, self.hand_centre, self.reach[1:], out)
        return out if near else None

    def check(self) -> "PressedStiffness":
        """Return itself where shapes and values are valid; BadInput otherwise."""
        nets, units, points = self.first.shape[0], self.first.shape[1], self.mix.shape[0]
        wide, numbers, hands = self.second.shape[1], self.hand_centre.size, self.hand_mix.shape[0]
        wanted = {
            "centre": (INPUTS,), "mix": (points, INPUTS), "hand_centre": (numbers,),
            "hand_mix": (hands, numbers), "first": (nets, units, points + hands + 1),
            "second": (nets, wide, units + 1), "last": (nets, 1, wide + 1),
            "reach": (1 + hands,), "error": (2,),
        }  # fmt: skip
        for name, shape in wanted.items():
            values = getattr(self, name)
            if values.shape != shape or (0 in shape and not name.startswith("hand")):
                raise BadInput(f"pressed/{name}: shape {values.shape}, expected {shape}")
            if not (np.abs(values) <= LARGEST).all():
                raise BadInput(f"pressed/{name}: a value is not finite, or beyond {LARGEST:g}")
        if nets > MOST_NETS or max(units, wide, points, hands) > MOST_UNITS:
            raise BadInput(f"pressed: more than {MOST_NETS} networks, or {MOST_UNITS} units")
        if numbers > MOST_NUMBERS or numbers % 2 or (numbers > 0) != (hands > 0):
            raise BadInput(
                f"pressed: {numbers} numbers of an empty closure, {hands} points of them"
            )
        if not ((self.reach > 0.0).all() and ((self.error > 0.0) & (self.error <= 5.0)).all()):
            raise BadInput("pressed: reach or error is out of range")
        return self


DOUBLES = ("centre", "hand_centre", "reach", "error")
FIELDS = {
    each.name: np.dtype("<f8" if each.name in DOUBLES else "<f4")
    for each in fields(PressedStiffness)
}
DIMENSIONS = {"mix": 2, "hand_mix": 2, "first": 3, "second": 3, "last": 3}


def bin_size(sampling: float) -> int:
    """Samples of a bin at `sampling` [Hz]; 0 where no whole number of them fills one."""
    size = round(BIN * sampling)
    return size if size and abs(size / sampling - BIN) < 1e-9 else 0


def due(touch: int, size: int) -> int | None:
    """Samples that must be there for the estimate, by that of the touch; None: there is none."""
    bin_ = touch // size if size else 0
    return (bin_ + GROUP * AFTER) * size if EARLIEST <= bin_ < LATEST else None


def trace_inputs(samples: np.ndarray, touch: int, sampling: float) -> np.ndarray:
    """Inputs (INPUTS,) of current, position and reference (3, n) with a touch at sample `touch`."""
    out, size = np.zeros(INPUTS), bin_size(sampling)
    inputs(samples[0], samples[1], samples[2], touch, 1.0 / sampling, size, out)
    return out
