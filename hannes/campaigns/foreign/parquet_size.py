"""To how much a Parquet file unpacks: its library believes what the head of each page states.

Room for a page is taken before it is unpacked into it. So the sum of what pages state is what may
become resident. Numbers of fields are those of parquet.thrift.
"""

from pathlib import Path
from typing import Any, BinaryIO

from hannes.campaigns.foreign.thrift import Reader, whole_u32
from hannes.core.errors import BadInput
from hannes.core.io.bounded import opened
from hannes.core.io.limits import BYTES, MIB

TAIL = 8  # bytes: the footer's length, and a mark
HEAD_OF_PAGE = 1 << 16  # bytes in which it must end
ROW_GROUPS, COLUMNS, META = 4, 1, 3  # of the footer, of a row group, of a column in it
PACKED, FIRST_DATA, DICTIONARY = 7, 9, 11  # of that: bytes, and where they lie
PAGE_UNPACKED, PAGE_PACKED = 2, 3


def require_unpackable(path: Path) -> None:
    """Raise BadInput where a file's pages would unpack to more than BYTES, or say nonsense."""
    with opened(path, "a Parquet file") as file:
        try:
            left = BYTES
            for start, size in _columns(file):
                left = _less_pages(file, start, size, left)
                if left < 0:
                    text = f"unpacks to more than {BYTES // MIB} MiB; cut it"
                    raise BadInput(f"{path}: {text}")
        except (ValueError, IndexError, TypeError, KeyError, OverflowError) as error:
            raise BadInput(f"{path}: cannot be read as Parquet ({error})") from None


def _columns(file: BinaryIO) -> list[tuple[int, int]]:
    """Where the pages of each column of each row group start, and how many bytes they take."""
    size = file.seek(0, 2)
    if size < 2 * TAIL:
        raise ValueError("too short")
    file.seek(size - TAIL)
    length = whole_u32(file.read(4))
    if length > size - TAIL:
        raise ValueError("its footer is longer than the file")
    file.seek(size - TAIL - length)
    footer = Reader(file.read(length)).fields()
    columns = (column[META] for group in footer.get(ROW_GROUPS, []) for column in group[COLUMNS])
    return [_pages_of(column) for column in columns]


def _pages_of(column: dict[int, Any]) -> tuple[int, int]:
    starts = [column[FIRST_DATA], column.get(DICTIONARY, 0)]
    return min(each for each in starts if each > 0), column[PACKED]


def _less_pages(file: BinaryIO, start: int, size: int, left: int) -> int:
    """`left` less what the pages of a column state that they unpack to."""
    end = start + size
    while start < end and left >= 0:
        file.seek(start)
        reader = Reader(file.read(min(HEAD_OF_PAGE, end - start)))
        page = reader.fields()
        packed, unpacked = page[PAGE_PACKED], page[PAGE_UNPACKED]
        if packed < 0 or unpacked < 0:
            raise ValueError("a page of less than no bytes")
        start += reader.at + packed
        left -= unpacked
    return left
