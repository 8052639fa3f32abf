"""How much a reader takes: one home for the limits of every file that hannes opens.

They are checked before the work, and while a packed file is unpacked: no size that a file states
about itself is believed. docs/reference/limits.md is made from `LIMITS`.
"""

from dataclasses import dataclass

MIB = 1 << 20


@dataclass(frozen=True)
class Limit:
    """One limit: its value, the unit of that, and of what it is."""

    value: int
    unit: str
    what: str


LIMITS = {
    "BYTES": Limit(512 * MIB, "bytes", "of any file, and of what it unpacks to"),
    "SHEET_BYTES": Limit(256 * MIB, "bytes", "of all that a spreadsheet unpacks to"),
    "TOML_BYTES": Limit(400_000, "bytes", "of a TOML file"),
    "TOML_PARTS": Limit(100, "parts", "of one dotted key in TOML"),
    "VALUES": Limit(50_000_000, "numbers", "of a file, all columns together (400 MB)"),
    "COLUMNS": Limit(2000, "columns", "of a file"),
    "CHANNELS": Limit(1000, "channels", "of a recording"),
    "LINE": Limit(4 * MIB, "bytes", "of one line of text"),
    "SEARCHED": Limit(250, "characters", "of a line, in which a mapping's text.skip is looked for"),
    "REPEATS": Limit(2, "repetitions", "in the pattern of text.skip, each of one character"),
    "UNPACKING": Limit(1100, "times", "that one block of HDF5 may grow when it is unpacked"),
    "FILE_UNPACKING": Limit(100, "times", "its size and 100 MiB: to what a data set may unpack"),
    "BLOCKS": Limit(1_000_000, "blocks", "in which one array of HDF5 is stored"),
    "SECONDS": Limit(300, "s", "of reading one text or packed file"),
    "MAGNITUDE": Limit(10**12, "SI", "of any sample, and of any time in s"),
}

BYTES = LIMITS["BYTES"].value
SHEET_BYTES = LIMITS["SHEET_BYTES"].value
TOML_BYTES = LIMITS["TOML_BYTES"].value
TOML_PARTS = LIMITS["TOML_PARTS"].value
VALUES = LIMITS["VALUES"].value
COLUMNS = LIMITS["COLUMNS"].value
CHANNELS = LIMITS["CHANNELS"].value
LINE = LIMITS["LINE"].value
SEARCHED = LIMITS["SEARCHED"].value
REPEATS = LIMITS["REPEATS"].value
UNPACKING = LIMITS["UNPACKING"].value
FILE_UNPACKING = LIMITS["FILE_UNPACKING"].value
BLOCKS = LIMITS["BLOCKS"].value
SECONDS = LIMITS["SECONDS"].value
MAGNITUDE = float(LIMITS["MAGNITUDE"].value)


def table_fits(rows: int, columns: int, decoded: int) -> bool:
    """Whether a table of float64 is in proportion to the `decoded` bytes that it comes from.

    Sparse records could otherwise become thousands of times as large: half of the 16 bytes resident
    a decoded byte are the table's, and 32 MiB.
    """
    return rows * columns <= min(VALUES, decoded + 4 * MIB)
