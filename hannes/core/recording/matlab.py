"""A recording as a MATLAB file: one column vector a channel, `units` and `metadata` beside them."""

import io
import re

from hannes.core.errors import BadInput
from hannes.core.recording.frames import Samples, metadata

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


def variable(name: str) -> str:
    """A channel's name as MATLAB takes it."""
    return re.sub(r"\W", "_", name)[:LONGEST]
