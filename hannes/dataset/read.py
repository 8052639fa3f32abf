"""Reads a finished data set; shapes and types are checked before numbers are read."""

import json
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from hannes.core.errors import BadInput
from hannes.core.io.inputs import is_file, note
from hannes.core.recording.hdf5 import OWN_FILTERS, text_attribute
from hannes.dataset.hdf5_file import SCHEMA
from hannes.dataset.shard import STORED

MOST_FIELDS = 2000
DENSEST = 1100  # highest compression ratio of deflate
LARGEST = 1e12  # N/m or N: any real one is far below
BLOCK = 500  # grasps in memory at once
NEEDED = ("role", "completed", "contact", "release", "peak_force", "object.stiffness")


@dataclass(frozen=True)
class DataSet:
    """Table of grasps, sample times [s], border [N/m] between soft and rigid; channels by block."""

    path: Path
    title: str
    table: np.ndarray
    time: np.ndarray
    border: float
    roles: tuple[str, ...]
    digest: str

    @property
    def rigid(self) -> np.ndarray:
        """Which objects count as rigid, shape (grasps,)."""
        return self.table["object.stiffness"] >= self.border

    @property
    def usable(self) -> np.ndarray:
        """Which grasps ended and touched their object, shape (grasps,)."""
        return (self.table["completed"] == 1) & np.isfinite(self.table["contact"])

    def role(self, name: str) -> np.ndarray:
        """Which grasps have a role, shape (grasps,)."""
        return self.table["role"] == self.roles.index(name)

    def blocks(self, rows: np.ndarray, names: tuple[str, ...]) -> Iterator[np.ndarray]:
        """Channels of the grasps in `rows` (ascending), shape (m, samples, names) at a time.

        Raises BadInput where the file is damaged or a sample is no number.
        """
        with _opened(self.path) as file:
            found = [_channel(file, name, self.table.size, self.time.size) for name in names]
            for start in range(0, rows.size, BLOCK):
                some = rows[start : start + BLOCK]
                whole = slice(int(some[0]), int(some[-1]) + 1)
                values = np.stack([each[whole][some - some[0]] for each in found], axis=-1)
                if not np.isfinite(values).all():
                    raise BadInput(f"{self.path}: a sample of grasps {some[0]} on is no number")
                yield values


def read(path: str | Path) -> DataSet:
    """Read a data set's table; BadInput where the file is another, or damaged."""
    with _opened(Path(path)) as file:
        if (schema := text_attribute(file, "schema")) != SCHEMA:
            raise BadInput(f"{path}: its schema is {schema!r:.60}, expected {SCHEMA!r}")
        table, time = _table(file["grasps"]), file["channels/time"]
        if time.dtype != np.dtype("<f8") or time.ndim != 1 or not 2 <= time.size <= 1_000_000:
            raise BadInput(f"{path}: channels/time: expected 2 or more float64 times")
        border, roles = float(file.attrs["border"]), json.loads(text_attribute(file, "roles"))
        title, digest = text_attribute(file, "title"), text_attribute(file, "fingerprint")
        found = DataSet(Path(path), title, table, time[()], border, tuple(roles), digest)
    _check(found)
    return found


def _check(found: DataSet) -> None:
    if not (np.isfinite(found.border) and found.border > 0.0):
        raise BadInput(f"{found.path}: its border of stiffness is {found.border} N/m")
    if "train" not in found.roles or "test" not in found.roles:
        raise BadInput(f"{found.path}: expected the roles train and test, got {found.roles!r:.60}")
    if not (np.isfinite(found.time).all() and (np.diff(found.time) > 0.0).all()):
        raise BadInput(f"{found.path}: channels/time does not increase")
    stiffness, peak = found.table["object.stiffness"], found.table["peak_force"][found.usable]
    if not ((stiffness > 0.0) & (stiffness <= LARGEST)).all():
        raise BadInput(f"{found.path}: an object's stiffness is no number above 0")
    if not (np.abs(peak) <= LARGEST).all():
        raise BadInput(f"{found.path}: a peak force is no number")


@contextmanager
def _opened(path: Path) -> Iterator[Any]:
    import h5py

    note(path)
    if not is_file(path):
        raise BadInput(f"{path}: expected a data set, there is no such file")
    try:
        with h5py.File(path, "r") as file:
            yield file
    except BadInput as error:
        message = str(error)
        raise BadInput(message if message.startswith(str(path)) else f"{path}: {message}") from None
    except Exception as error:  # a damaged file raises nearly anything from inside the library
        reason = " ".join(str(error).split())[:100]
        raise BadInput(
            f"{path}: cannot be read as a data set, it is damaged or of another kind ({reason})"
        ) from None


def _table(dataset: Any) -> np.ndarray:
    """The table of grasps; only fields of plain numbers."""
    kinds = dataset.dtype.fields
    if kinds is None or dataset.ndim != 1 or len(kinds) > MOST_FIELDS:
        raise BadInput("/grasps: expected a table with a row a grasp")
    if any(kind.kind not in "iuf" or kind.itemsize > 8 for kind, *_ in kinds.values()):
        raise BadInput("/grasps: expected fields of plain numbers")
    if missing := [name for name in NEEDED if name not in kinds]:
        raise BadInput(f'/grasps: the field "{missing[0]}" is missing')
    _plain(dataset)
    return dataset[()]


def _channel(file: Any, name: str, grasps: int, samples: int) -> Any:
    if f"channels/{name}" not in file:
        raise BadInput(f'the channel "{name}" is missing; keep it in channels of the specification')
    dataset = file["channels"][name]
    if dataset.dtype != np.dtype(STORED) or dataset.shape != (grasps, samples):
        raise BadInput(f'channel "{name}": expected {STORED} of shape {(grasps, samples)}')
    if dataset.chunks and dataset.chunks[0] * samples > 50_000_000:
        raise BadInput(f'channel "{name}": chunks of {dataset.chunks} are too large to read')
    _plain(dataset)
    return dataset


def _plain(dataset: Any) -> None:
    """Refuse storage outside the file, and filters that need a plugin."""
    made = dataset.id.get_create_plist()
    filters = {made.get_filter(k)[0] for k in range(made.get_nfilters())}
    if dataset.is_virtual or dataset.external or not filters <= OWN_FILTERS:
        raise BadInput(f"{dataset.name}: expected plain or gzip storage inside this file")
    if dataset.size * dataset.dtype.itemsize > DENSEST * max(dataset.id.get_storage_size(), 1):
        raise BadInput(f"{dataset.name}: claims far more rows than the file holds")
