"""The method's text as part of another module, so that numba compiles the two as one.

A function passed to compiled code costs more than the whole right-hand side; a name of the same
module costs nothing.
"""

import inspect
import re
from collections.abc import Callable, Mapping
from typing import Any

from hannes.core.kernels.jit import kernel
from hannes.simulation.rodas import step, whole_tick

PARTS: tuple[Callable[..., Any], ...] = (
    step.keep_piece,
    step.attempt,
    step.step,
    step.first_step,
    step.bound_after,
    step.advance,
    whole_tick.settle,
    whole_tick.whole_tick,
    whole_tick.advance_tick,
    step.sample_pieces,
)
# What the text reaches by name.
_WRITTEN = {part.__name__ for part in PARTS}
NAMES = {
    name: value
    for name, value in (vars(whole_tick) | vars(step)).items()
    if not name.startswith("__") and name not in _WRITTEN
}


def source() -> str:
    """Functions of the method with `problem.` dropped: `slope` and the like are then globals."""
    text = "\n\n".join(inspect.getsource(part) for part in PARTS)
    return re.sub(r"\bproblem(\.|, )", "", text)


def compiled(functions: Mapping[str, Any]) -> dict[str, Any]:
    """The method over compiled functions of a problem, by name: see `problem.compiled`.

    Machine code lives as long as the process; the hand's own is kept on disk (assemble.py).
    """
    space = {**NAMES, **functions, "kernel": kernel}
    exec(re.sub(r"^def ", "@kernel\ndef ", source(), flags=re.MULTILINE), space)
    return space
