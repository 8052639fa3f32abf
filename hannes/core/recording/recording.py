"""One class for measured and simulated recordings of any plant.

Channels and units are those that the plant declares; the hand's are `time_s, reference_rad,
position_rad, current_A, duty_1, supply_V, force_N, sensor_N`. Only time and one more are required.
"""

from collections.abc import ItemsView, Iterable, Iterator, KeysView, Mapping, ValuesView
from dataclasses import dataclass, fields, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any, Self

import numpy as np

from hannes.core.errors import BadInput, nearest
from hannes.core.recording import soundness
from hannes.core.recording.soundness import FloatArray

SCHEMA = "hannes-recording-1"
SUFFIXES = (".csv", ".csv.gz", ".h5", ".hdf5")


@dataclass(frozen=True, eq=False, repr=False)
class Recording(Mapping[str, FloatArray]):
    """Channels over time: equally long, finite, read-only float64 arrays; `time` [s] first.

    A mapping of channel names, as a table is of its columns: `recording["current"]`, `in`,
    iteration, `keys`, `values`, `items`, `get`. Its length is that of its columns: the samples.

    `units` gives each channel's unit ("1" for none). `experiment` and `hand` are resolved TOML
    texts, empty where unknown; `seed` is None where nothing was drawn; `conversion` (JSON) says
    how a foreign file became this. Raises BadInput on creation for anything that is no recording.
    """

    channels: Mapping[str, FloatArray]
    units: Mapping[str, str]
    plant: str = ""
    experiment: str = ""
    hand: str = ""
    seed: int | None = None
    source: str = "measured"
    schema: str = SCHEMA
    conversion: str = ""

    def __post_init__(self) -> None:
        soundness.check_names(self.channels, self.units)
        order = ["time", *(name for name in self.channels if name != "time")]
        arrays = {name: soundness.frozen(name, self.channels[name]) for name in order}
        soundness.check_time(arrays)
        soundness.check_metadata(self, SCHEMA)
        object.__setattr__(self, "channels", MappingProxyType(arrays))
        units = MappingProxyType({name: self.units[name] for name in order})
        object.__setattr__(self, "units", units)

    @classmethod
    def read(cls, path: str | Path) -> Self:
        """Read a .csv, .csv.gz, .h5 or .hdf5 file; BadInput names the file and the line."""
        return cls.from_csv(path) if is_csv(path) else cls.from_hdf5(path)

    @classmethod
    def from_csv(cls, path: str | Path, **metadata: Any) -> Self:
        """Read `name_unit` columns; `metadata` are further fields, which CSV does not carry."""
        from hannes.core.recording import csv

        channels, units = csv.load(Path(path))
        try:
            return cls(channels, units, **metadata)
        except BadInput as error:  # the rows were checked line by line: only the header is left
            raise BadInput(f"{path}, line 1: {error}") from None

    @classmethod
    def from_hdf5(cls, path: str | Path) -> Self:
        """Read group `/channels` and the root attributes."""
        from hannes.core.recording import hdf5

        content = hdf5.load(Path(path))
        try:
            return cls(**content)
        except BadInput as error:
            raise BadInput(f"{path}: {error}") from None

    def write(self, path: str | Path) -> None:
        """Write a .csv, .csv.gz, .h5 or .hdf5 file, whole or not at all."""
        if is_csv(path):
            self.to_csv(path)
        else:
            self.to_hdf5(path)

    def to_csv(self, path: str | Path) -> None:
        """Write all channels with the digits that read back to the same floats."""
        from hannes.core.io import atomic_files
        from hannes.core.recording import csv

        packed = str(path).lower().endswith(".gz")
        atomic_files.write_bytes(path, csv.dump(self.channels, self.units, packed))

    def to_hdf5(self, path: str | Path) -> None:
        """Write everything; the same content gives the same bytes."""
        from hannes.core.io import atomic_files
        from hannes.core.recording import hdf5

        atomic_files.write_bytes(path, hdf5.dump(self.channels, self.units, self.metadata()))

    def metadata(self) -> dict[str, Any]:
        """All but the channels and their units, by name; None for what a file leaves out."""
        found = {each.name: getattr(self, each.name) for each in fields(self)[2:]}
        return found | {"conversion": self.conversion or None}

    def to_mat(self, path: str | Path) -> None:
        """Write a MATLAB file: a column vector a channel, units and metadata beside them."""
        from hannes.core.io import atomic_files
        from hannes.core.recording import matlab

        atomic_files.write_bytes(path, matlab.dump(self))

    def to_mcap(self, path: str | Path) -> None:
        """Write an MCAP log, one JSON message a sample; BadInput where mcap is not installed."""
        from hannes.core.io import atomic_files
        from hannes.core.recording import mcap

        atomic_files.write_bytes(path, mcap.dump(self))

    def to_pandas(self) -> Any:
        """Return a DataFrame over `time_s`; BadInput where pandas is not installed."""
        from hannes.core.recording import frames

        return frames.data_frame(self)

    def to_xarray(self) -> Any:
        """Return a Dataset over `time`, with units; BadInput where xarray is not installed."""
        from hannes.core.recording import frames

        return frames.dataset(self)

    @property
    def time(self) -> FloatArray:
        """Sampling instants [s], strictly increasing; a gap in the data is a gap here."""
        return self.channels["time"]

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all channels besides time."""
        return tuple(name for name in self.channels if name != "time")

    def __getitem__(self, name: str) -> FloatArray:
        if name not in self.channels:
            hint = f"{nearest(name, self.names)} (it has {', '.join(self.names)})"
            raise BadInput(f'the recording has no channel "{name}"{hint}')
        return self.channels[name]

    def get(self, name: str, default: Any = None) -> Any:
        """Return a channel, or `default` where there is none of that name."""
        return self.channels.get(name, default)

    def __contains__(self, name: object) -> bool:
        return name in self.channels

    def __iter__(self) -> Iterator[str]:
        return iter(self.channels)

    def __len__(self) -> int:
        return len(self.time)

    def keys(self) -> KeysView[str]:
        """Names of all channels, time first."""
        return self.channels.keys()

    def values(self) -> ValuesView[FloatArray]:
        """Arrays of all channels, time first."""
        return self.channels.values()

    def items(self) -> ItemsView[str, FloatArray]:
        """Names and arrays of all channels, time first."""
        return self.channels.items()

    def with_channels(self, added: Mapping[str, Any], units: Mapping[str, str]) -> Self:
        """Return a copy with channels added or replaced; `units` may leave out known ones."""
        return replace(self, channels={**self.channels, **added}, units={**self.units, **units})

    def between(self, t0: float, t1: float) -> Self:
        """Return the samples with t0 <= time <= t1 [s]; BadInput if fewer than two are left."""
        inside = (self.time >= t0) & (self.time <= t1)
        if np.count_nonzero(inside) < 2:
            raise BadInput(
                f"fewer than two samples lie between {t0:g} and {t1:g} s; "
                f"the recording goes from {self.time[0]:g} to {self.time[-1]:g} s"
            )
        return replace(self, channels={name: each[inside] for name, each in self.channels.items()})

    def expect(
        self, declared: Mapping[str, str], required: Iterable[str] = (), what: str = "the plant"
    ) -> Self:
        """Return self if every channel is `declared` with the same unit and `required` ones exist.

        Raises BadInput otherwise; `what` names in its message who declares the channels.
        """
        for name in self.names:
            if name not in declared:
                hint = f"{nearest(name, declared)} (it declares {', '.join(declared)})"
                raise BadInput(f'channel "{name}" is unknown to {what}{hint}')
            unit, wanted = self.units[name], declared[name]
            if unit != wanted:
                advice = "convert the values and rename the column"
                raise BadInput(f'channel "{name}" comes in {unit}, expected {wanted}: {advice}')
        for name in required:
            self[name]
        return self

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Recording):
            return NotImplemented
        return _plain(self) == _plain(other) and all(
            np.array_equal(each, other.channels[name]) for name, each in self.channels.items()
        )

    __hash__ = None  # type: ignore[assignment]

    def __reduce__(self) -> tuple[Any, ...]:
        rest = (getattr(self, each.name) for each in fields(self)[2:])
        return type(self), (dict(self.channels), dict(self.units), *rest)

    def __repr__(self) -> str:
        columns = ", ".join(f"{name} [{self.units[name]}]" for name in self.names)
        origin = f"{self.source}, plant {self.plant}" if self.plant else self.source
        span = f"{self.time[0]:g} to {self.time[-1]:g} s"
        return f"Recording({origin}: {len(self)} samples, {span}; {columns})"


def is_csv(path: str | Path) -> bool:
    """Return whether a name is that of a CSV file, not HDF5; BadInput where it is neither's."""
    name = str(path).lower()
    if not name.endswith(SUFFIXES):
        raise BadInput(
            f"{path}: expected a recording named {', '.join(SUFFIXES)}; a raw log is read through "
            "a mapping: `hannes begin` writes one, and a campaign names it (mapping = ...)"
        )
    return name.endswith((".csv", ".csv.gz"))


def _plain(recording: Recording) -> tuple[Any, ...]:
    rest = [getattr(recording, each.name) for each in fields(recording)[2:]]
    return list(recording.channels), dict(recording.units), rest
