"""A recording as tables of other libraries: pandas' DataFrame, xarray's Dataset."""

from collections.abc import Mapping, Sequence
from typing import Any, Protocol

import numpy as np

from hannes.core.io.optional import library

METADATA = ("plant", "experiment", "hand", "seed", "source", "schema")


class Samples(Protocol):
    """What of a recording stands in a table: channels over one time, each with its unit."""

    @property
    def channels(self) -> Mapping[str, np.ndarray]:
        """Values by name, time among them, shape (n,) each."""

    @property
    def units(self) -> Mapping[str, str]:
        """Unit by name."""

    @property
    def names(self) -> Sequence[str]:
        """Names of all channels but time."""

    @property
    def time(self) -> np.ndarray:
        """Times of the samples, shape (n,), s."""


def data_frame(recording: Samples) -> Any:
    """A DataFrame indexed by `time_s`, with columns such as `current_A`; metadata in `attrs`."""
    pandas = library("pandas", "export")
    columns = {f"{n}_{recording.units[n]}": recording.channels[n] for n in recording.names}
    frame = pandas.DataFrame(columns, index=pandas.Index(recording.time, name="time_s"))
    frame.attrs.update(metadata(recording))
    return frame


def dataset(recording: Samples) -> Any:
    """A Dataset over `time`, with variables such as `current` and their unit in `attrs`."""
    xarray = library("xarray", "export")
    variables = {
        name: ("time", recording.channels[name], {"units": recording.units[name]})
        for name in recording.names
    }
    made = xarray.Dataset(variables, {"time": recording.time}, metadata(recording))
    made["time"].attrs["units"] = "s"
    return made


def metadata(recording: Samples) -> dict[str, Any]:
    """What is known of a recording beside its channels; unknown fields are left out."""
    found = {name: getattr(recording, name) for name in METADATA}
    return {name: value for name, value in found.items() if value not in ("", None)}
