"""Names of a plant's functions and kernels against those of the code that runs its equations.

All of it becomes one text: a function of the same name would silently stand in for the plant's own.
"""

import re
from types import ModuleType

from hannes.core.errors import BadInput
from hannes.core.kernels.jit import plain

_DEFINED = re.compile(r"^def (\w+)\(", re.MULTILINE)


def require_own_names(module: ModuleType, source: str, running: str) -> None:
    """Raise BadInput where a plant's function, or one that it calls, has a name that is taken.

    source: text of the plant's equations;  running: text of all that runs them
    """
    called = {name for name, each in vars(module).items() if hasattr(plain(each), "__code__")}
    own = called | {*_DEFINED.findall(source)}
    if taken := sorted(own & {*_DEFINED.findall(running)}):
        raise BadInput(
            f"{module.__file__}: {taken[0]} is the name of a function that runs the equations: "
            "give yours another one"
        )
