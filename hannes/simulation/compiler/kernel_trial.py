"""A kernel called with made-up numbers: what it adds at `off`, and whether it leaves its input."""

import re
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from hannes.core.effect import Effect, Term
from hannes.core.kernels import jit

TRIALS = 4  # draws of all that a kernel reads: one alone may meet a root's other side
ARRAY = re.compile(r"\[(\d+):(\d+)\]$")  # ends the text of an argument that is no single number


def fault(compiled: Callable[..., Any], effect: Effect, term: Term, given: Sequence[str]) -> str:
    """What a kernel does that none may, or an empty string.

    `given` are the texts of its arguments in generated code; slices of arrays have their sizes.
    """
    off = {each.name: each.off for each in effect.amplitudes}
    draws = np.random.default_rng(0)
    added = list[np.ndarray]()
    for _ in range(TRIALS):
        values = [
            _value(n, text, off, draws) for n, text in zip(term.arguments, given, strict=True)
        ]
        if why := _breaks(compiled, jit.plain(term.kernel), term, values):
            return why
        returned = np.atleast_1d(np.asarray(compiled(*values), float))
        added.append(returned[: len(term.writes)])
    return _at_off(np.array(added), term)


def _value(name: str, text: str, off: Mapping[str, float | None], draws: Any) -> Any:
    """A number, or an array of as many as its slice has."""
    if name in off:
        return off[name]
    found = ARRAY.search(text)
    return draws.uniform(0.1, 1.0, int(found[2]) - int(found[1]) if found else None)


def _breaks(
    compiled: Callable[..., Any], function: Callable[..., Any], term: Term, values: list[Any]
) -> str:
    """Whether it reads beyond an array, or writes into one."""
    arrays = {
        n: v for n, v in zip(term.arguments, values, strict=True) if isinstance(v, np.ndarray)
    }
    if not arrays:
        return ""
    before = {name: array.copy() for name, array in arrays.items()}
    try:
        function(*values)  # as plain Python: machine code does not look where an array ends
    except IndexError as error:
        return f"reads beyond an array: {error}"
    except (ArithmeticError, ValueError):  # numbers that machine code takes, as it does infinity
        pass
    for name, array in arrays.items():
        if not np.array_equal(array, before[name]):
            return f"changes {name}, which it may only read"
    return ""


def _at_off(added: np.ndarray, term: Term) -> str:
    """What it adds with all amplitudes at `off`, one row a trial, where that is not exactly 0."""
    for values, name in zip(added.T, term.writes, strict=True):
        if not np.isfinite(values).any():
            return f"adds {values[0]} to {name} where its amplitude is `off`: expected 0"
        wrong = values[np.isfinite(values) & (values != 0.0)]
        if wrong.size:
            return f"adds {wrong[0]:.3g} to {name} where its amplitude is `off`: expected exactly 0"
    return ""
