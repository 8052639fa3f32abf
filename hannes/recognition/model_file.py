"""A model as a file: plain HDF5 arrays. Nothing in it is ever executed; all of it is checked.

attributes    schema, trained (text), window [s], hop [s], sampling [Hz], border [N/m], sure [1],
              features (of a window, then of a grasp), peak ("let go", or "held": see Model),
              pressed ("traces", or "none")
/rigid, /stiffness, /force    the arrays of a forest (forest.py)
/peak         those of gaussian_process.py, if `peak` says so: enough grasps were let go to learn
/pressed      those of pressed.py, if `pressed` says so
/calibration (2, n), /stiffness_band (3, n), /force_band (3, n)
"""

import io
import json
from pathlib import Path
from typing import Any

import numpy as np

from hannes.core.errors import BadInput
from hannes.core.io import atomic_files
from hannes.core.io.json_text import parsed
from hannes.core.recording.hdf5 import set_attribute, text_attribute
from hannes.core.recording.hdf5_storage import hdf5_file, member, require_plain
from hannes.recognition import gaussian_process, pressed
from hannes.recognition.features import NAMES
from hannes.recognition.forest import FIELDS, MOST_NODES, Forest
from hannes.recognition.gaussian_process import MOST_POINTS as MOST_PROCESS_POINTS
from hannes.recognition.gaussian_process import ProcessMean
from hannes.recognition.hysteresis_features import WHOLE
from hannes.recognition.model import Band, Calibration, Model
from hannes.recognition.windowing import Windowing

SCHEMA = "hannes-recogniser-10"
LET_GO, STILL_HELD = "let go", "held"
TRACES, NONE = "traces", "none"
MOST_WEIGHTS = pressed.MOST_NETS * pressed.MOST_UNITS * (pressed.MOST_UNITS + 1)
FORESTS = ("rigid", "stiffness", "force")
LARGEST = 100.0  # of the logarithm of an estimate: any real one is far below
CURVES = {"calibration": 2, "stiffness_band": 3, "force_band": 3}
NUMBERS = ("window", "hop", "sampling", "border", "sure")
OF_WINDOWING = NUMBERS[:3]
MOST_POINTS = 100_000


def write(path: str | Path, model: Model) -> None:
    """Write a model, whole or not at all; the same model gives the same bytes.

    BadInput where it is so large that it would not be read back.
    """
    import h5py

    memory = io.BytesIO()
    with h5py.File(memory, "w", libver=("v108", "v110")) as file:
        texts = {"schema": SCHEMA, "trained": model.trained, "features": json.dumps(WHOLE)}
        texts["peak"] = LET_GO if model.peak else STILL_HELD
        texts["pressed"] = TRACES if model.pressed else NONE
        for key, text in texts.items():
            set_attribute(file, key, text)
        for key in NUMBERS:
            file.attrs[key] = float(getattr(model.windowing if key in OF_WINDOWING else model, key))
        for name in FORESTS:
            _put(file, name, getattr(model, name), FIELDS)
        if model.peak:
            _put(file, "peak", model.peak, gaussian_process.FIELDS)
        if model.pressed:
            _put(file, "pressed", model.pressed, pressed.FIELDS)
        for name in CURVES:
            points = np.stack(list(vars(getattr(model, name)).values()))
            file.create_dataset(name, data=points, dtype="<f8", track_times=False)
    with h5py.File(io.BytesIO(memory.getvalue()), "r") as file:
        _model(file)
    atomic_files.write_bytes(path, memory.getvalue())


def _put(file: Any, name: str, made: Any, fields: dict[str, np.dtype]) -> None:
    for field, kind in fields.items():
        array = getattr(made, field).astype(kind)
        file.create_dataset(f"{name}/{field}", data=array, compression="gzip", track_times=False)


def read(path: str | Path) -> Model:
    """Read a model; BadInput in one line where the file is damaged, foreign or out of bounds."""
    with hdf5_file(path, "a model") as file:
        return _model(file)


def _model(file: Any) -> Model:
    if (schema := text_attribute(file, "schema")) != SCHEMA:
        raise BadInput(f"its schema is {schema!r:.60}, expected {SCHEMA!r}")
    if parsed(text_attribute(file, "features")) != list(WHOLE):
        raise BadInput("it was trained on other features than this version makes; train it anew")
    window, hop, sampling, border, sure = (_number(file, key) for key in NUMBERS)
    forests = {name: _forest(file, name).check(len(NAMES)) for name in FORESTS}
    curves = {name: _curve(file, name, rows) for name, rows in CURVES.items()}
    if (forests["rigid"].value < 0.0).any() or (forests["rigid"].value > 1.0).any():
        raise BadInput("a probability is not between 0 and 1")
    if max(np.abs(forests[name].value).max() for name in ("stiffness", "force")) > LARGEST:
        raise BadInput(f"the logarithm of an estimate is beyond {LARGEST:g}")
    peak = _process(file).check(len(WHOLE)) if _let_go(file) else None
    if peak and np.abs(peak.ends).max() > LARGEST:
        raise BadInput(f"the logarithm of a peak force is beyond {LARGEST:g}")
    if not 0.5 <= sure <= 1.0:
        raise BadInput(f"attribute sure = {sure:g}: expected 0.5 to 1")
    return Model(
        Windowing(window, hop, sampling),
        border,
        sure,
        **forests,
        peak=peak,
        calibration=Calibration(*curves["calibration"]),
        stiffness_band=Band(*curves["stiffness_band"]),
        force_band=Band(*curves["force_band"]),
        trained=text_attribute(file, "trained"),
        pressed=_pressed(file),
    )


def _number(file: Any, key: str) -> float:
    attribute = file.attrs.get_id(key)
    if attribute.dtype.kind != "f" or attribute.shape != ():
        raise BadInput(f"attribute {key} is not a number")
    value = float(file.attrs[key])
    if not (np.isfinite(value) and 0.0 < value <= 1e7):
        raise BadInput(f"attribute {key} = {value:g} is out of range")
    return value


def _forest(file: Any, name: str) -> Forest:
    return Forest(
        **{
            field: _array(file, f"{name}/{field}", kind, MOST_NODES + 1)
            for field, kind in FIELDS.items()
        }
    )


def _let_go(file: Any) -> bool:
    if (how := text_attribute(file, "peak")) not in (LET_GO, STILL_HELD):
        raise BadInput(f"attribute peak = {how!r:.60}: expected {LET_GO!r} or {STILL_HELD!r}")
    return how == LET_GO


def _process(file: Any) -> ProcessMean:
    most = len(WHOLE) * MOST_PROCESS_POINTS
    return ProcessMean(
        **{
            field: _array(file, f"peak/{field}", kind, most, 2 if field == "points" else 1)
            for field, kind in gaussian_process.FIELDS.items()
        }
    )


def _pressed(file: Any) -> pressed.PressedStiffness | None:
    if (how := text_attribute(file, "pressed")) not in (TRACES, NONE):
        raise BadInput(f"attribute pressed = {how!r:.60}: expected {TRACES!r} or {NONE!r}")
    if how == NONE:
        return None
    return pressed.PressedStiffness(
        **{
            field: _array(
                file, f"pressed/{field}", kind, MOST_WEIGHTS, pressed.DIMENSIONS.get(field, 1)
            )
            for field, kind in pressed.FIELDS.items()
        }
    ).check()


def _curve(file: Any, name: str, rows: int) -> np.ndarray:
    points = _array(file, name, np.dtype("<f8"), rows * MOST_POINTS, ndim=2)
    if points.shape[0] != rows or points.shape[1] < 1 or not np.isfinite(points).all():
        raise BadInput(f"{name}: expected {rows} rows of finite numbers")
    if (np.diff(points[0]) < 0.0).any() or np.abs(points).max() > 100.0:
        raise BadInput(f"{name}: its first row must rise, within 100")
    return points


def _array(file: Any, place: str, kind: np.dtype, most: int, ndim: int = 1) -> np.ndarray:
    """An array, after its type and size were judged."""
    import h5py

    dataset = member(file, place, h5py.Dataset)
    if dataset.dtype != kind or dataset.ndim != ndim:
        raise BadInput(f"{place}: expected an array of {kind} with {ndim} axis")
    return require_plain(dataset, most)[()]
