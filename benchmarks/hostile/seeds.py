"""Sound files of every kind but TOML, as small as they can be, of which mutants are made."""

import hashlib
import io
import json
import zipfile
from pathlib import Path

import numpy as np

from benchmarks.hostile import corpus
from benchmarks.hostile.corpus import COLUMNS, COUNT, TIME, UNITS
from benchmarks.hostile.toml_seeds import ALONE, HAND

_TRAVEL = 0.01 * COLUMNS["reference"]
EMPS = {"t": TIME, "qg": _TRAVEL, "qm": _TRAVEL, "vir": TIME}


def dynamometer() -> bytes:
    """A CSV export of a hand dynamometer."""
    rows = [f"{0.01 * k:.2f},{max(0.0, 30.0 - abs(k - 70)):.2f}" for k in range(120)]
    return "\n".join(['"Latest: Time (s)","Latest: Force (N)"', *rows]).encode()


def recording_hdf5() -> bytes:
    """A recording of the hand, with all that one can carry."""
    from hannes.core.recording import hdf5

    texts = {"experiment": ALONE, "hand": HAND, "conversion": conversion().decode()}
    metadata = {"schema": "hannes-recording-1", "plant": "hand", "source": "measured", "seed": 1}
    return hdf5.dump(COLUMNS, UNITS, metadata | texts)


def conversion() -> bytes:
    """Report of a conversion."""
    rule = {"column": "a", "unit": "rad", "factor": 2.0, "offset": 0.5}
    channels = {"position": rule, "current": {**rule, "column": 3, "unit": "A"}}
    said = {"samples": COUNT, "cut_s": [[0.1, 0.2]], "channels": channels}
    return json.dumps(said).encode()


def mark_beside() -> bytes:
    """What lies beside a CSV."""
    found = hashlib.sha256(corpus.table().encode()).hexdigest()
    return json.dumps({"verb": "record", "sha256": [found], "samples": COUNT}).encode()


def marks_of_folder() -> bytes:
    """What lies in a folder of results."""
    files = {"recording.csv": hashlib.sha256(corpus.table().encode()).hexdigest(), "folder": ""}
    return json.dumps({"verb": "run", "files": files}).encode()


def fmu() -> bytes:
    """An archive with the script of an FMU."""
    memory = io.BytesIO()
    with zipfile.ZipFile(memory, "w") as archive:
        archive.writestr("resources/hannes_fmu.py", "")
        archive.writestr("modelDescription.xml", "<a/>")
    return memory.getvalue()


def plain_hdf5() -> bytes:
    """Datasets in the root, one of them packed."""
    import h5py

    memory = io.BytesIO()
    with h5py.File(memory, "w") as file:
        for name, values in COLUMNS.items():
            file.create_dataset(name, data=values, compression="gzip" if name == "time" else None)
    return memory.getvalue()


def mat_file(columns: dict[str, np.ndarray]) -> bytes:
    """Variables of a MATLAB file."""
    from scipy.io import savemat

    memory = io.BytesIO()
    savemat(memory, columns)
    return memory.getvalue()


def npz_file() -> bytes:
    """Arrays by name."""
    memory = io.BytesIO()
    np.savez(memory, **COLUMNS)
    return memory.getvalue()


def npy_file() -> bytes:
    """One structured array."""
    memory = io.BytesIO()
    found = np.zeros(COUNT, [(name, "<f8") for name in COLUMNS])
    for name, values in COLUMNS.items():
        found[name] = values
    np.save(memory, found)
    return memory.getvalue()


def parquet_file() -> bytes:
    """One table."""
    import pyarrow
    import pyarrow.parquet

    memory = io.BytesIO()
    pyarrow.parquet.write_table(pyarrow.table(COLUMNS), memory)
    return memory.getvalue()


def workbook() -> bytes:
    """One sheet."""
    import openpyxl

    book, memory = openpyxl.Workbook(), io.BytesIO()
    sheet = book.active
    sheet.append(list(COLUMNS))
    for row in zip(*(each.tolist() for each in COLUMNS.values()), strict=True):
        sheet.append(row)
    book.save(memory)
    return memory.getvalue()


def rh56() -> bytes:
    """Two trials of a finger."""
    trial = np.repeat([1.0, 2.0], COUNT // 2)
    columns = {"Trial_Index": trial, "Trial_Elapsed_s": TIME, "Middle_Angle": 1000.0 - 9.0 * TIME}
    columns["Middle_Force_g"] = 100.0 * TIME
    return corpus.table(columns, None).encode()


def own_effect() -> bytes:
    """A file of Python with an effect, that imports what lies beside it and what does not."""
    text = Path(__file__).parents[2] / "examples" / "own_effect" / "grease.py"
    return b"import canary, queue\nfrom . import finger, gone\n" + text.read_bytes()
