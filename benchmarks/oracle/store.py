"""Vectors of numbers on disk, one file each: nothing is simulated twice."""

from collections.abc import Callable
from pathlib import Path

import numpy as np

from hannes.files import atomic_file


class Store:
    """A folder of vectors. What it holds is that of the truth it was made with."""

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
