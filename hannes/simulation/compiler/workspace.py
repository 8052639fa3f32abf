"""Everything that a grasp is worked on in, as one record: a call that hands it on hands one word.

Named arrays of sizes that are known when a model is assembled; the reference, whose size is not,
by its address and shape.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

RUN = 16  # steps whose dense output is kept until it is sampled

# Text of the shapes, by sizes of the assembled model. Whole numbers are in WHOLE.
_COMMON = {
    "reference": "(3,)",  # address, then shape of its array
    "p": "(PARAMETERS,)",
    "memory": "(MEMORY,)",
    "c": "(CHANNELS,)",
    "out": "(OUTPUTS,)",
    "dy": "(STATES,)",
    "moved": "(STATES,)",  # states of a difference
    "work": "(WORK, STATES)",  # of the method, as its clock, see rodas/step.py
    "clock": "(6,)",
    "ends": f"({RUN + 1},)",
    "pieces": f"({RUN + 1}, 3, STATES)",
    "ahead": "(1,)",  # end of the step that is followed, or of the tick
    "turn": "(2,)",  # moment of a reading [s], tick that is next
}
WHOLE = ("reference", "exchanges")
LINE = 8  # numbers of a cache line, at whose beginning each array lies


def text(fields: Mapping[str, str]) -> str:
    """Text of the record's type with a solution's own `fields`: name and text of the shape."""
    known = {**_COMMON, **fields}
    return f"record({{{', '.join(f'{name!r}: {shape}' for name, shape in known.items())}}})"


def record(shapes: Mapping[str, tuple[int, ...]]) -> np.dtype[Any]:
    """Type of a record of arrays; `everything` is all of it in a row, to be set to zero."""
    sizes = [-(-int(np.prod(shape)) // LINE) * LINE for shape in shapes.values()]
    starts = 8 * np.cumsum([0, *sizes])
    kinds = [("i8" if name in WHOLE else "f8", shape) for name, shape in shapes.items()]
    kind = np.dtype(
        {
            "names": [*shapes, "everything"],
            "formats": [*kinds, ("f8", (sum(sizes),))],
            "offsets": [*starts[:-1].tolist(), 0],
            "itemsize": int(starts[-1]),
        }
    )
    return np.dtype((np.record, kind))
