"""Vectors of numbers on disk, one file each: nothing is simulated twice.

Another truth has another folder: what two versions of it made must never meet in a difference.
"""

import hashlib
from collections.abc import Callable
from pathlib import Path

import numpy as np

from hannes.core.io.atomic_files import atomic_file


class Store:
    """A folder of vectors."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def kept(self, name: str, make: Callable[[], np.ndarray]) -> np.ndarray:
        """The vector of this name; made and written where it is not there yet."""
        file = self.folder / f"{name}.npy"
        if not file.exists():
            made = make()
            with atomic_file(file) as temporary, temporary.open("wb") as stream:
                np.save(stream, made)
        return np.load(file)


def digest(folder: Path) -> str:
    """Of all sources in a folder."""
    found = hashlib.sha256()
    for source in sorted(folder.rglob("*.py")):
        found.update(source.name.encode() + source.read_bytes())
    return found.hexdigest()[:12]
