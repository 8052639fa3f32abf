"""A recording as a MATLAB file: one column vector a channel, `units` and `metadata` beside them."""

import io
import re
import struct
import zlib
from pathlib import Path
from typing import Any, BinaryIO

from hannes.core.errors import BadInput
from hannes.core.io.bounded import BLOCK, opened
from hannes.core.io.limits import BYTES, MIB
from hannes.core.recording.frames import Samples, metadata

HEADER = 116  # bytes of text at the head, where a date would stand
TAG, COMPRESSED = 8, 15  # bytes before each element, and its kind where that is packed
LONGEST = 63  # letters of a MATLAB name


def dump(recording: Samples) -> bytes:
    """The file (version 5); the same recording gives the same bytes.

    Letters that MATLAB's names cannot have become `_`. Raises BadInput where two channels would
    then share a name.
    """
    from scipy.io import savemat

    names = {name: variable(name) for name in recording.channels}
    if len(set(names.values())) < len(names) or {"units", "metadata"} & set(names.values()):
        raise BadInput(f"channels {', '.join(names)} have no names of their own in MATLAB")
    content: dict[str, object] = {names[n]: each for n, each in recording.channels.items()}
    content["units"] = {names[n]: unit for n, unit in recording.units.items()}
    content["metadata"] = metadata(recording)
    buffer = io.BytesIO()
    savemat(buffer, content, long_field_names=True, oned_as="column")
    text = b"MATLAB 5.0 MAT-file, written by hannes".ljust(HEADER)
    return text + buffer.getvalue()[HEADER:]


def load_mat(path: Path) -> dict[str, Any]:
    """Variables of a MATLAB file by name, structures as dicts, cells as lists.

    Raises BadInput where it is none, or unpacks to too much; NotImplementedError for version 7.3.
    """
    from scipy.io import loadmat

    with opened(path, "a MATLAB file") as file:
        try:
            _require_small(file)
            file.seek(0)
            content: dict[str, Any] = loadmat(file, simplify_cells=True)
        except (BadInput, NotImplementedError):
            raise
        except Exception as error:  # a damaged file raises nearly anything from inside the library
            reason = " ".join(str(error).split())[:100]
            raise BadInput(f"{path}: is no MATLAB file, or damaged ({reason})") from None
    return content


def _require_small(file: BinaryIO) -> None:
    """Unpack the packed elements of a version 5 file as far as they may go, and keep nothing."""
    head = file.read(128)
    order = {b"IM": "<", b"MI": ">"}.get(head[126:128])
    left = BYTES
    while order and len(tag := file.read(TAG)) == TAG:
        kind, size = struct.unpack(f"{order}II", tag)
        if kind != COMPRESSED:
            file.seek(size, io.SEEK_CUR)
            continue
        packed = zlib.decompressobj()
        while size > 0 and (data := file.read(min(size, BLOCK))):
            size -= len(data)
            while data and left > 0:
                left -= len(packed.decompress(data, BLOCK))
                data = packed.unconsumed_tail
            if left <= 0:
                raise BadInput(f"{file.name}: unpacks to more than {BYTES // MIB} MiB")


def variable(name: str) -> str:
    """A channel's name as MATLAB takes it."""
    return re.sub(r"\W", "_", name)[:LONGEST]
