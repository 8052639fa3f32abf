"""A kernel of the user's own that numba cannot compile: one line instead of sixty."""

from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

from hannes.core.errors import BadInput

LONGEST = 160  # characters of numba's reason


class _Own(NamedTuple):
    """A kernel of the user's own: its file, its effect's name, the kernel."""

    path: Path
    effect: str
    kernel: Any

    @property
    def name(self) -> str:
        return str(self.kernel.__name__)


def blamed(error: Exception) -> BadInput | None:
    """Return what to raise where `error` is numba refusing a user's kernel, None elsewhere.

    It names the file, the kernel and numba's reason. Numba compiles when a model first runs, deep
    inside a command, and says in its text alone which function it was, if at all.
    """
    if type(error).__module__.partition(".")[0] != "numba":
        return None
    found, text = _kernels(), str(error)
    named = [each for each in found if _mentions(text, each)]
    named = named or [each for each in found if _refuses(each.kernel)]
    if not named:
        return None
    where = "; ".join(dict.fromkeys(f"{each.path}: kernel {each.name}" for each in named))
    return BadInput(
        f"{where} cannot be compiled: {_reason(text)}; "
        "a kernel may use numbers, arrays, numpy, math and functions marked @kernel"
    )


def _kernels() -> list[_Own]:
    from hannes.simulation.catalogue import own_effects

    return [
        _Own(Path(place.rpartition(":")[0]), effect.name, term.kernel)
        for place, effect in own_effects().items()
        for term in effect.terms
    ]


def _mentions(text: str, own: _Own) -> bool:
    """Whether numba's text has the function, its call in the model, or a line of its file."""
    signs = (f"<function {own.name} at", f"{own.effect}__{own.name}", f'{own.path.name}"')
    return any(sign in text for sign in signs)


def _refuses(kernel: Callable[..., Any]) -> bool:
    """Whether numba refuses a kernel by itself, all its arguments being numbers."""
    import inspect

    from hannes.core.kernels import jit

    function = jit.plain(kernel)
    numbers = ", ".join("float64" for _ in inspect.signature(function).parameters)
    try:
        jit.kernel(function).compile(f"({numbers},)")
    except Exception:  # numba's errors have no common class
        return True
    return False


def _reason(text: str) -> str:
    """The first thing numba says that is not which of its passes failed, on one line."""
    lines = [each.strip() for each in text.splitlines() if each.strip()]
    start = next((k for k, each in enumerate(lines) if "Failed in" not in each), 0)
    said = lines[start]
    if said.endswith(":"):  # the signature follows
        said = " ".join([said, *(each.lstrip("> ") for each in lines[start + 1 : start + 2])])
    return said[:LONGEST].rstrip(".")
