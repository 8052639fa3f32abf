"""Reads a finished data set; shapes and types are checked before numbers are read."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from hannes.core.errors import BadInput
from hannes.core.io.json_text import parsed
from hannes.core.io.limits import FILE_UNPACKING, MIB, VALUES
from hannes.core.recording.hdf5 import text_attribute
from hannes.core.recording.hdf5_storage import hdf5_file, member, require_plain
from hannes.dataset.empty_closure import STORED as EMPTY_STORED
from hannes.dataset.hdf5_file import SCHEMA
from hannes.dataset.shard import STORED

MOST_FIELDS = 2000
LARGEST = 1e12  # N/m or N: any real one is far below
BLOCK = 500  # grasps in memory at once
SPREAD = 20_000  # rows of the file among which they lie
MOST_IN_MEMORY = 12_500_000  # values of a block, 50 MB
MOST_SAMPLES = 10_000_000_000  # of a channel: it is read by blocks
EMPTY, MOST_EMPTY = "empty", 1000  # field of the hands that closed on nothing; its numbers
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

    def empty(self, rows: np.ndarray) -> np.ndarray:
        """What the hands of grasps `rows` showed as they closed on nothing, shape (m, numbers).

        NaN where one did not; no numbers at all where the data set has none.
        """
        fields = self.table.dtype.names or ()
        if EMPTY not in fields or self.table.dtype[EMPTY].subdtype is None:
            return np.zeros((rows.size, 0))
        return self.table[EMPTY][rows].astype(float)

    def role(self, name: str) -> np.ndarray:
        """Which grasps have a role, shape (grasps,)."""
        return self.table["role"] == self.roles.index(name)

    def blocks(self, rows: np.ndarray, names: tuple[str, ...]) -> Iterator[np.ndarray]:
        """Channels of the grasps in `rows` (ascending), shape (m, samples, names) at a time.

        Raises BadInput where the file is damaged or a sample is no number.
        """
        with _opened(self.path) as file:
            found = [_channel(file, name, self.table.size, self.time.size) for name in names]
            self._require_in_proportion(found)
            for some in _together(rows, self.time.size * len(names)):
                whole = slice(int(some[0]), int(some[-1]) + 1)
                values = np.stack([each[whole][some - some[0]] for each in found], axis=-1)
                if not np.isfinite(values).all():
                    raise BadInput(f"{self.path}: a sample of grasps {some[0]} on is no number")
                yield values

    def _require_in_proportion(self, channels: list[Any]) -> None:
        """A file that unpacks to far more than its size is no data set of noisy grasps."""
        unpacked = sum(each.size * each.dtype.itemsize for each in channels)
        if unpacked > FILE_UNPACKING * self.path.stat().st_size + 100 * MIB:
            raise BadInput(
                f"{self.path}: unpacks to {unpacked // MIB} MiB, more than {FILE_UNPACKING} times "
                "its size"
            )


def _together(rows: np.ndarray, width: int) -> Iterator[np.ndarray]:
    """Ascending `rows` of `width` values in parts that lie close together, BLOCK at most.

    What lies between the first and the last of a part is read, too.
    """
    most = max(1, min(BLOCK, MOST_IN_MEMORY // width))
    start = 0
    while start < rows.size:
        near = np.searchsorted(rows, rows[start] + max(most, min(SPREAD, MOST_IN_MEMORY // width)))
        end = min(start + most, int(near))
        yield rows[start:end]
        start = end


def read(path: str | Path) -> DataSet:
    """Read a data set's table; BadInput where the file is another, or damaged."""
    import h5py

    with _opened(Path(path)) as file:
        if (schema := text_attribute(file, "schema")) != SCHEMA:
            raise BadInput(f"{path}: its schema is {schema!r:.60}, expected {SCHEMA!r}")
        table = _table(member(file, "grasps", h5py.Dataset))
        time = require_plain(member(file, "channels/time", h5py.Dataset))
        if time.dtype != np.dtype("<f8") or time.ndim != 1 or not 2 <= time.size <= 1_000_000:
            raise BadInput(f"{path}: channels/time: expected 2 or more float64 times")
        border, roles = float(file.attrs["border"]), parsed(text_attribute(file, "roles"))
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
    shown = found.empty(np.arange(found.table.size))
    fine = (np.abs(shown) <= LARGEST).all(axis=1) | np.isnan(shown).all(axis=1)
    if not fine.all():
        raise BadInput(
            f"{found.path}: grasp {int(np.argmin(fine))} has an empty closure with gaps: expected "
            "all of its numbers or none; make the data set anew"
        )


@contextmanager
def _opened(path: Path) -> Iterator[Any]:
    with hdf5_file(path, "a data set") as file:
        yield file


def _table(dataset: Any) -> np.ndarray:
    """The table of grasps; only fields of plain numbers."""
    kinds = dataset.dtype.fields
    if kinds is None or dataset.ndim != 1 or len(kinds) > MOST_FIELDS:
        raise BadInput("/grasps: expected a table with a row a grasp")
    if any(not _is_plain(name, kind) for name, (kind, *_) in kinds.items()):
        raise BadInput("/grasps: expected fields of plain numbers")
    if missing := [name for name in NEEDED if name not in kinds]:
        raise BadInput(f'/grasps: the field "{missing[0]}" is missing')
    require_plain(dataset, VALUES // max(_numbers(dataset.dtype), 1))
    return dataset[()]


def _numbers(row: np.dtype) -> int:
    """How many numbers a row of a table has, those of an empty closure counted one by one."""
    return sum(int(np.prod(kind.shape)) for kind, *_ in (row.fields or {}).values())


def _is_plain(name: str, kind: np.dtype) -> bool:
    """Whether a field is a plain number, or what an empty closure shows of a hand."""
    if name == EMPTY and kind.subdtype is not None:
        base, shape = kind.subdtype
        return base == np.dtype(EMPTY_STORED) and len(shape) == 1 and 2 <= shape[0] <= MOST_EMPTY
    return kind.kind in "iuf" and kind.itemsize <= 8


def _channel(file: Any, name: str, grasps: int, samples: int) -> Any:
    import h5py

    if name not in member(file, "channels", h5py.Group):
        raise BadInput(f'the channel "{name}" is missing; keep it in channels of the specification')
    dataset = member(file, f"channels/{name}", h5py.Dataset)
    if dataset.dtype != np.dtype(STORED) or dataset.shape != (grasps, samples):
        raise BadInput(f'channel "{name}": expected {STORED} of shape {(grasps, samples)}')
    return require_plain(dataset, MOST_SAMPLES)
