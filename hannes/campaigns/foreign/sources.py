"""Which reader opens which file; what is not read is named as what it is, with the way round."""

from collections.abc import Callable
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from hannes.campaigns.foreign.binary_columns import open_hdf5, require_file
from hannes.campaigns.foreign.json_columns import open_json
from hannes.campaigns.foreign.mapping import Column, TextRule
from hannes.campaigns.foreign.matlab_columns import open_mat
from hannes.campaigns.foreign.message_columns import open_messages
from hannes.campaigns.foreign.npz_columns import open_npz
from hannes.campaigns.foreign.parquet_columns import is_lerobot, open_parquet
from hannes.campaigns.foreign.plain_table import plain_table
from hannes.campaigns.foreign.sheet_columns import open_sheet
from hannes.campaigns.foreign.text_columns import Delimited
from hannes.core.errors import BadInput
from hannes.core.io.bounded import opened

FloatArray = NDArray[np.float64]


class Source(Protocol):
    """A foreign file: its columns as numbers, NaN where a value is missing."""

    def numbers(self, column: Column) -> FloatArray:
        """Values of a column in its own unit, shape (n,)."""

    def stamps(self, column: Column, pattern: str = "") -> FloatArray:
        """Times of a column, shape (n,), s."""

    def labels(self, column: Column) -> FloatArray:
        """A number for each distinct value of a column, shape (n,)."""

    def breaks(self, kind: str) -> NDArray[np.intp]:
        """Rows before which a blank line or a repeated header stands."""

    def place(self, row: int) -> str:
        """Where in the file a row stands, for messages."""


Opener = Callable[[Path, tuple[str, ...]], Source]

READERS: dict[str, Opener] = {
    ".h5": open_hdf5,
    ".hdf5": open_hdf5,
    ".hdf": open_hdf5,
    ".he5": open_hdf5,
    ".mat": open_mat,
    ".json": open_json,
    ".jsonl": open_json,
    ".ndjson": open_json,
    ".npz": open_npz,
    ".npy": open_npz,
    ".parquet": open_parquet,
    ".xlsx": open_sheet,
    ".xlsm": open_sheet,
    ".mcap": open_messages,
    ".bag": open_messages,
    ".db3": open_messages,
}

# Beginnings of files that are not read as they are, what they are, and the way round.
NOT_READ = (
    (b"TDSm", "a LabVIEW TDMS file", "export it as text (.lvm or .csv)"),
    (b"TDSh", "the index of a LabVIEW TDMS file", "export the .tdms beside it as text"),
    (b"MDF ", "an ASAM MDF measurement", "export it as .csv or .mat"),
    (b"ULog", "a PX4 flight log", "convert it with ulog2csv"),
    (b"LOGG", "a Vector BLF log", "export it as .csv"),
    (b"SQLite format 3", "an SQLite database", "export the table as .csv"),
    (b"\xd0\xcf\x11\xe0", "an old Office file (.xls)", "save it as .xlsx or .csv"),
    (b"\x80\x04\x95", "a Python pickle, which could run code", "save the arrays as .npz"),
    (b"\x80\x03", "a Python pickle, which could run code", "save the arrays as .npz"),
    (b"\x80\x05\x95", "a Python pickle, which could run code", "save the arrays as .npz"),
    (b"RDX", "an R data file", "export it as .csv"),
    (b"ARROW1", "an Arrow (Feather) file", "save it as .parquet"),
    (b"7z\xbc\xaf", "a 7-Zip archive", "unpack it first"),
    (b"Rar!", "a RAR archive", "unpack it first"),
    (b"%PDF", "a PDF", "ask for the numbers behind it"),
    (b"\x89PNG", "a picture", "ask for the numbers behind it"),
    (b"\xff\xd8\xff", "a picture", "ask for the numbers behind it"),
    (b"\x7fELF", "a program", "name the log instead"),
)
ZIP = b"PK\x03\x04"
BY_CONTENT: dict[bytes, Opener] = {
    b"\x89HDF\r\n": open_hdf5,
    b"MATLAB ": open_mat,
    b"PAR1": open_parquet,
    b"\x89MCAP0\r\n": open_messages,
}


def open_source(path: Path, text: TextRule, missing: tuple[str, ...]) -> Source:
    """Open a foreign file by the end of its name, else by its first bytes, else as text.

    Raises BadInput where it is of a kind that is not read, saying which, and what to do.
    """
    reader = reader_of(path)
    if reader is not None:
        return reader(path, missing)
    return plain_table(path, text, missing) or Delimited(path, text, missing)


def reader_of(path: Path) -> Opener | None:
    """What reads a file or folder that is no text, None for text; BadInput for what is not read."""
    if path.is_dir():
        return _folder(path)
    if (reader := READERS.get(path.suffix.lower())) is not None:
        return reader
    start = _first_bytes(path)
    for magic, what, way_round in NOT_READ:
        if start.startswith(magic):
            raise BadInput(f"{path}: is {what}, which is not read; {way_round}")
    if start.startswith(ZIP):
        raise BadInput(f"{path}: is a ZIP archive; unpack it first (an .xlsx needs that ending)")
    return next((opener for magic, opener in BY_CONTENT.items() if start.startswith(magic)), None)


def _folder(path: Path) -> Opener:
    if is_lerobot(path):
        return open_parquet
    if (path / "metadata.yaml").is_file():
        return open_messages
    raise BadInput(
        f"{path}: is a folder; expected files, a LeRobot data set (with meta/info.json), or a "
        "rosbag2 (with metadata.yaml)"
    )


def _first_bytes(path: Path) -> bytes:
    require_file(path)
    with opened(path) as file:
        return file.read(16)
