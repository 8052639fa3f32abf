"""Where tests find the recordings of the RH56 finger, which are never part of the project."""

import os
from pathlib import Path

import pytest


def rh56_files(pattern: str) -> list[Path]:
    """Files of that pattern, sorted; the test is skipped where this machine has none."""
    folder = Path(os.environ.get("HANNES_MEASURED", "nowhere")) / "rh56_finger"
    if not (files := sorted(folder.glob(pattern))):
        pytest.skip("needs the RH56 recordings: HANNES_MEASURED names no folder with them")
    return files
