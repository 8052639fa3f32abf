"""Reads the EMPS files (MATLAB) into recordings of the axis."""

from pathlib import Path

import numpy as np

from hannes.core.errors import BadInput
from hannes.core.io.inputs import note
from hannes.core.recording.recording import Recording

# MATLAB name -> channel, unit. The file says `pulses_N`; they are volts added to the output.
CHANNELS = {
    "t": ("time", "s"),
    "qg": ("reference", "m"),
    "qm": ("position", "m"),
    "vir": ("drive", "V"),
    "pulses_N": ("pulses", "V"),
}


def load(path: str | Path) -> Recording:
    """Read DATA_EMPS.mat or DATA_EMPS_PULSES.mat; BadInput where it is no such file."""
    from scipy.io import loadmat

    note(path)
    try:
        content = loadmat(path)
    except OSError as error:
        raise BadInput(f"cannot read {path}: {error.strerror or error}") from None
    except Exception as error:  # a damaged file raises nearly anything from inside the library
        reason = " ".join(str(error).split())[:100]
        raise BadInput(f"{path} is no MATLAB recording, or damaged: {reason}") from None
    found = {name: content[name] for name in CHANNELS if name in content}
    if missing := [name for name in ("t", "qg", "qm", "vir") if name not in found]:
        raise BadInput(f"{path} lacks {', '.join(missing)}: expected a recording of EMPS")
    channels = {CHANNELS[name][0]: np.ravel(values) for name, values in found.items()}
    units = {CHANNELS[name][0]: CHANNELS[name][1] for name in found}
    return Recording(channels, units, plant="axis")
