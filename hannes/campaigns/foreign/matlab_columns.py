"""Variables of a MATLAB file: those inside structures, arrays of structures and cells by path.

`log.signals(1).values` is `log/signals/1/values`. Version 7.3 is HDF5.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from hannes.campaigns.foreign.binary_columns import Arrays, open_hdf5, require_file
from hannes.core.recording.matlab import load_mat

DEEPEST = 13  # levels of structures in cells in structures
LABELS = ("label", "name", "signalName")  # of a signal, whose numbers are its `values`


def open_mat(path: Path, missing: tuple[str, ...]) -> Arrays:
    """Read the numeric variables of a MATLAB file."""
    require_file(path)
    try:
        content = load_mat(path)
    except NotImplementedError:  # version 7.3
        return open_hdf5(path, missing)
    own = {name: each for name, each in content.items() if not name.startswith("__")}
    variables = dict(_variables("", own, 0))
    captions = dict(_captions("", own, 0))
    return Arrays(
        path, variables, variables.__getitem__, missing, captions, units=_units(own.get("units"))
    )


def _units(value: Any) -> dict[str, str]:
    """Texts of a structure `units`, by the variables of their names, as `hannes export` has it."""
    if not isinstance(value, dict):
        return {}
    return {name: each for name, each in value.items() if isinstance(each, str)}


def _inside(name: str, value: Any) -> Iterator[tuple[str, Any]]:
    """Fields of a structure, or elements from 1 of cells and of arrays of structures, by path."""
    if isinstance(value, dict):
        for key, each in value.items():
            yield f"{name}/{key}".lstrip("/"), each
    elif isinstance(value, list) or (isinstance(value, np.ndarray) and value.dtype == object):
        each_one = np.ravel(value) if isinstance(value, np.ndarray) else value
        for number, each in enumerate(each_one, start=1):
            yield f"{name}/{number}", each


def _variables(name: str, value: Any, depth: int) -> Iterator[tuple[str, Any]]:
    """Numbers below a variable."""
    if depth > DEEPEST:
        return
    if isinstance(value, dict | list) or (np.asarray(value).dtype == object):
        for path, each in _inside(name, value):
            yield from _variables(path, each, depth + 1)
    elif np.asarray(value).dtype.kind in "fiub" and np.asarray(value).size:
        yield name, value


def _captions(name: str, value: Any, depth: int) -> Iterator[tuple[str, str]]:
    """What labels beside them say of arrays called `values`, as a Simulink scope saves them."""
    if depth > DEEPEST:
        return
    if isinstance(value, dict) and "values" in value:
        texts = (value.get(key) for key in LABELS)
        label = next((each for each in texts if isinstance(each, str) and each.strip()), "")
        if label:
            yield f"{name}/values", label
    for path, each in _inside(name, value):
        yield from _captions(path, each, depth + 1)
