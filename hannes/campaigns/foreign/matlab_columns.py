"""Variables of a MATLAB file: those inside structures, arrays of structures and cells by path.

`log.signals(1).values` is `log/signals/1/values`. Version 7.3 is HDF5.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from hannes.campaigns.foreign.binary_columns import Arrays, open_hdf5, require_file
from hannes.core.recording.matlab import load_mat

DEEPEST = 12  # levels of structures in cells in structures


def open_mat(path: Path, missing: tuple[str, ...]) -> Arrays:
    """Read the numeric variables of a MATLAB file."""
    require_file(path)
    try:
        content = load_mat(path)
    except NotImplementedError:  # version 7.3
        return open_hdf5(path, missing)
    variables = {
        name: value
        for top, inside in content.items()
        if not top.startswith("__")
        for name, value in _variables(top, inside, 0)
    }
    return Arrays(path, variables, variables.__getitem__, missing)


def _variables(name: str, value: Any, depth: int) -> Iterator[tuple[str, Any]]:
    """Numbers below a variable; elements of cells and of arrays of structures from 1."""
    if depth > DEEPEST:
        return
    if isinstance(value, dict):
        for key, each in value.items():
            yield from _variables(f"{name}/{key}", each, depth + 1)
    elif isinstance(value, list) or (isinstance(value, np.ndarray) and value.dtype == object):
        for number, each in enumerate(np.ravel(value) if isinstance(value, np.ndarray) else value):
            yield from _variables(f"{name}/{number + 1}", each, depth + 1)
    elif np.asarray(value).dtype.kind in "fiub" and np.asarray(value).size:
        yield name, value
