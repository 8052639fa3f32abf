"""A recording as a MATLAB file: one column vector a channel, `units` and `metadata` beside them."""

import io
import re
from pathlib import Path
from typing import Any

from hannes.core.errors import BadInput
from hannes.core.io.bounded import opened
from hannes.core.recording.frames import Samples, metadata
from hannes.core.recording.matlab_structure import check_structure

HEADER = 116  # bytes of text at the head, where a date would stand
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
            check_structure(file)
            file.seek(0)
            content: dict[str, Any] = loadmat(file, simplify_cells=True)
        except (BadInput, NotImplementedError):
            raise
        except Exception as error:  # a damaged file raises nearly anything from inside the library
            reason = " ".join(str(error).split())[:100]
            raise BadInput(f"{path}: is no MATLAB file, or damaged ({reason})") from None
    return content


def variable(name: str) -> str:
    """A channel's name as MATLAB takes it."""
    return re.sub(r"\W", "_", name)[:LONGEST]
