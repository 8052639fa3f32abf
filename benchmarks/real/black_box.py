"""Two models that know nothing of a servo, run freely from its command: a lag, and an ARX model."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from hannes.core.recording.recording import Recording

OUTPUTS = 3  # of an ARX model: positions before; its commands take what parameters are left


@dataclass(frozen=True)
class DelayedLag:
    """time y' = gain u(t - delay) + offset - y, from where the recording starts."""

    delay: float
    time: float
    gain: float
    offset: float

    @classmethod
    def fitted(cls, recordings: Sequence[Recording]) -> "DelayedLag":
        """Of least squares of the freely run position, from several delays."""
        starts = [(delay, 0.1, 1.0, 0.0) for delay in (0.02, 0.06, 0.12)]
        low, high = (0.0, 5e-3, 0.1, -1.0), (0.5, 5.0, 3.0, 1.0)
        return cls(*_least(lambda x: cls(*x), recordings, starts, (low, high)))

    def position(self, recording: Recording) -> np.ndarray:
        """Position [rad], shape (n,)."""
        time, command = recording.time, recording["reference"]
        wanted = self.gain * np.interp(time - self.delay, time, command) + self.offset
        found = np.empty(time.size)
        found[0] = recording["position"][0]
        kept = np.exp(-np.diff(time) / self.time)
        for k, each in enumerate(kept):
            found[k + 1] = each * found[k] + (1.0 - each) * wanted[k]
        return found


@dataclass(frozen=True)
class ARX:
    """y_k = sum a_i y_(k-i) + sum b_j u_(k-j) + c, run on its own positions, sample by sample."""

    numbers: tuple[float, ...]  # a, b, c

    @classmethod
    def fitted(cls, recordings: Sequence[Recording], size: int) -> "ARX":
        """Of `size` numbers: by equation error first, then by the freely run position."""
        columns = [_regressors(each, size) for each in recordings]
        rows, values = (np.concatenate(each) for each in zip(*columns, strict=True))
        start = np.linalg.lstsq(rows, values, rcond=None)[0]
        bounds = (np.full(size, -3.0), np.full(size, 3.0))
        start = np.clip(start, -2.99, 2.99)
        calm = np.zeros(size)  # another start: a plain lag of 0.1 s
        calm[0], calm[OUTPUTS] = 0.8, 0.2
        return cls(tuple(_least(lambda x: cls(tuple(x)), recordings, [start, calm], bounds)))

    def position(self, recording: Recording) -> np.ndarray:
        """Position [rad], shape (n,)."""
        from scipy.signal import lfilter, lfiltic

        a, b = self.numbers[:OUTPUTS], self.numbers[OUTPUTS:-1]
        first, command = recording["position"][0], recording["reference"]
        forced = np.convolve(command, b)[: command.size] + self.numbers[-1]
        forced[: len(b)] += command[0] * np.array([sum(b[k + 1 :]) for k in range(len(b))])
        denominator = np.r_[1.0, -np.array(a)]
        state = lfiltic([1.0], denominator, np.full(OUTPUTS, first))
        found = lfilter([1.0], denominator, forced, zi=state)[0]
        return np.r_[first, np.clip(found[:-1], -10.0, 10.0)]


def _regressors(recording: Recording, size: int) -> tuple[np.ndarray, np.ndarray]:
    y, u = recording["position"], recording["reference"]
    commands = size - OUTPUTS - 1
    first = max(OUTPUTS, commands)
    rows = [y[first - i : y.size - i] for i in range(1, OUTPUTS + 1)]
    rows += [u[first - j : u.size - j] for j in range(1, commands + 1)]
    return np.column_stack([*rows, np.ones(y.size - first)]), y[first:]


class Model(Protocol):
    """What runs freely from a command."""

    def position(self, recording: Recording) -> np.ndarray:
        """Position [rad], shape (n,)."""


def _least(
    make: Callable[[np.ndarray], Model],
    recordings: Sequence[Recording],
    starts: Sequence[Sequence[float] | np.ndarray],
    bounds: tuple[Sequence[float] | np.ndarray, Sequence[float] | np.ndarray],
) -> np.ndarray:
    """Parameters of least squares of the freely run position, the best from any start."""
    from scipy.optimize import least_squares

    def residual(x: np.ndarray) -> np.ndarray:
        model = make(x)
        left = [model.position(each) - each["position"] for each in recordings]
        return np.nan_to_num(np.concatenate(left), nan=10.0, posinf=10.0, neginf=-10.0)

    fits = [least_squares(residual, x, bounds=bounds, x_scale="jac", max_nfev=60) for x in starts]
    return min(fits, key=lambda each: float(each.cost)).x
