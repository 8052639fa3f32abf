"""Reads the EMPS files (MATLAB) into recordings of the axis."""

from pathlib import Path

import numpy as np

from hannes.core.errors import BadInput
from hannes.core.recording.matlab import load_mat
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
    try:
        content = load_mat(Path(path))
    except NotImplementedError:
        raise BadInput(f"{path}: MATLAB 7.3, expected a recording of EMPS (version 5)") from None
    found = {name: content[name] for name in CHANNELS if name in content}
    if missing := [name for name in ("t", "qg", "qm", "vir") if name not in found]:
        raise BadInput(f"{path} lacks {', '.join(missing)}: expected a recording of EMPS")
    channels = {CHANNELS[name][0]: np.ravel(values) for name, values in found.items()}
    units = {CHANNELS[name][0]: CHANNELS[name][1] for name in found}
    return Recording(channels, units, plant="axis")
