"""Recordings as HDF5: group `/channels` of 1-D float64 datasets, and root attributes.

Bytes depend on the content alone: no time stamps, one file format version, no compression. A file
may come from anywhere, so its shapes are checked before its numbers are read. Nothing outside the
file is read (external links and storage, virtual data, plugin filters), and no text of variable
length: where that is damaged, HDF5 itself loops or crashes (4 of 1500 files with bytes flipped).
"""

import io
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hannes.core.errors import BadInput
from hannes.core.io.limits import CHANNELS, VALUES
from hannes.core.recording.hdf5_storage import hdf5_file, member, require_plain

FloatArray = NDArray[np.float64]

_TEXTS = ("schema", "plant", "experiment", "hand", "source", "conversion")


def dump(
    channels: Mapping[str, FloatArray], units: Mapping[str, str], metadata: Mapping[str, Any]
) -> bytes:
    """Return the file's bytes; a `seed` of None is left out."""
    import h5py

    memory = io.BytesIO()
    with h5py.File(memory, "w", libver=("v108", "v110")) as file:
        for key, value in metadata.items():
            set_attribute(file, key, value)
        group = _new_group(file)
        for name, values in channels.items():
            dataset = group.create_dataset(name, data=values, dtype="<f8", track_times=False)
            set_attribute(dataset, "unit", units[name])
    return memory.getvalue()


def load(path: Path) -> dict[str, Any]:
    """Return channels, units and metadata as `Recording` takes them; BadInput otherwise."""
    with hdf5_file(path, "an HDF5 file") as file:
        return _content(file)


def set_attribute(item: Any, key: str, value: str | int | None) -> None:
    """Attach an attribute, text with a fixed length; None is left out."""
    import h5py

    if isinstance(value, str):
        data = value.encode()
        item.attrs.create(key, data, dtype=h5py.string_dtype("utf-8", max(len(data), 1)))
    elif value is not None:
        item.attrs[key] = value


def _new_group(file: Any) -> Any:
    """Create `/channels` with the order of its members, without time stamps."""
    import h5py

    properties = h5py.h5p.create(h5py.h5p.GROUP_CREATE)
    properties.set_link_creation_order(h5py.h5p.CRT_ORDER_TRACKED | h5py.h5p.CRT_ORDER_INDEXED)
    properties.set_obj_track_times(False)
    return h5py.Group(h5py.h5g.create(file.id, b"channels", gcpl=properties))


def _content(file: Any) -> dict[str, Any]:
    metadata = {key: text_attribute(file, key) for key in _TEXTS if key in file.attrs}
    if "schema" not in metadata:
        raise BadInput("is not a recording: the root attribute schema is missing")
    datasets = _datasets(file)
    units = {name: text_attribute(each, "unit") for name, each in datasets.items()}
    channels = {name: each[()] for name, each in datasets.items()}
    return {"channels": channels, "units": units, "seed": _seed(file), **metadata}


def _datasets(file: Any) -> dict[str, Any]:
    """Return the channels' datasets, each with plain storage; numbers are not read yet."""
    import h5py

    group = member(file, "channels", h5py.Group)
    if len(group) > CHANNELS:
        raise BadInput(f"has {len(group)} channels, more than {CHANNELS}")
    datasets = {name: member(group, name, h5py.Dataset) for name in group}
    total = sum(each.size or 0 for each in datasets.values())
    if total > VALUES:
        raise BadInput(f"holds {total} values, more than {VALUES}; cut it into shorter ones")
    for name, each in datasets.items():
        _check_storage(name, each)
    if len({each.shape for each in datasets.values()}) > 1:
        raise BadInput("has channels of unequal length")
    return datasets


def _check_storage(name: str, dataset: Any) -> None:
    if dataset.shape is None or len(dataset.shape) != 1 or dataset.dtype not in ("<f8", ">f8"):
        raise BadInput(f'channel "{name}": expected a 1-D float64 dataset')
    require_plain(dataset)


def text_attribute(item: Any, key: str) -> str:
    """Return a text attribute of fixed length; BadInput where it is missing or another kind."""
    if key not in item.attrs:
        raise BadInput(f'"{item.name}" lacks the attribute {key}')
    if (length := _text_length(item, key)) is None:
        raise BadInput(
            f'attribute {key} of "{item.name}" is text of variable length: write it with a fixed '
            "one (h5py: attrs[name] = numpy.bytes_(text.encode())), or go through CSV"
        )
    value = item.attrs[key] if length > 0 else None
    if isinstance(value, bytes):
        value = value.decode()
    if not isinstance(value, str):
        raise BadInput(f'attribute {key} of "{item.name}" is not text')
    return value


def _text_length(item: Any, key: str) -> int | None:
    """Bytes of a text, None where that varies, 0 for anything else; its value is not touched."""
    import h5py

    attribute = item.attrs.get_id(key)
    text = h5py.check_string_dtype(attribute.dtype)
    return text.length if text is not None and attribute.shape == () else 0


def _seed(file: Any) -> int | None:
    if "seed" not in file.attrs:
        return None
    attribute = file.attrs.get_id("seed")
    whole = attribute.dtype.kind in "iu" and attribute.shape == ()
    value = file.attrs["seed"] if whole else None
    if not isinstance(value, np.integer):
        raise BadInput("attribute seed is not a whole number")
    return int(value)
