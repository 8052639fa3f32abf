"""The file of a data set: shards into HDF5 and back, the same bytes for the same shards.

    /channels/NAME   float32, a row a grasp, a column a sample; attribute unit
    /channels/time   float64 [s], the dimension scale of the columns
    /grasps          a row a grasp: its sampled values and its results; attribute units, by field
    /digests         SHA-256 of each shard's rows and chunks, by which damage is found

Attributes `meanings` of the root and of the table say in JSON what is what (ROOT, MEANINGS).
"""

import hashlib
import inspect
import json
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from hannes.contact import shapes
from hannes.core.errors import BadInput
from hannes.core.io.atomic_files import BODY_FAULTS
from hannes.core.io.provenance import versions
from hannes.core.recording.hdf5 import set_attribute
from hannes.dataset import distributions, empty_closure, sampling, shard
from hannes.dataset.shard import SIZE, STORED, Shard, chunk, count, table_type, units
from hannes.dataset.spec import ROLES, Spec
from hannes.simulation.experiment import clearance, experiment
from hannes.simulation.hand import anatomy, hand
from hannes.simulation.hand import variables as channels
from hannes.simulation.sensors import UNITS, noisy

SCHEMA = "hannes-dataset-1"
PLOTTING = ("matplotlib",)  # packages on which no byte depends
DEPENDS_ON = (  # sources that sample, pose and pack; kernels and values enter by themselves
    *(distributions, empty_closure, sampling, shard, clearance, noisy),
    *(anatomy, channels, experiment, hand, shapes),
)
ROOT = {
    "specification": "TOML, resolved: all that was asked for",
    "seed": "of all random numbers; a grasp's are its own, by its number",
    "border": "N/m: an object counts as rigid from this object.stiffness on",
    "groups": "names, by the number in the column group",
    "shapes": "of the groups' objects",
    "roles": "names, by the number in the column role",
    "fingerprint": "SHA-256 of specification, model and versions: equal ones make equal bytes on "
    "processors of a kind",
    "channels": "a row a grasp, a column a sample; position and reference at the output shaft",
    "digests": "SHA-256 of each hundred grasps, rows and chunks, by which damage is found",
}
MEANINGS = {
    "number": "place in the data set, and key of the grasp's random numbers beside the seed",
    "noise_seed": "of the noise on the grasp's channels",
    "group": "place in the root's groups",
    "role": "place in the root's roles: to train on, to test with, or to train the stiffness on",
    "contact": "first sample above 5 % of the peak of total force, and 1 N; no number without one",
    "release": "last such sample",
    "peak_force": "largest total normal force",
    "empty": "current, then lag, in means of 20 ms while the hand closes on nothing; no numbers "
    "where it did not",
    "completed": "1 where the simulation ended; else its samples after the failure are no numbers",
}


def fingerprint(spec: Spec) -> str:
    """Digest of all that the bytes depend on: specification, model, sampling, packing, versions."""
    model = Path(str(spec.hand.compiled(spec.hand.effects).fast.__file__)).stem
    sources = [inspect.getsource(each) for each in DEPENDS_ON]
    libraries = {name: each for name, each in versions().items() if name not in PLOTTING}
    values = dict(spec.hand.parameters)
    known = json.dumps([SCHEMA, spec.text, values, model, sources, libraries], sort_keys=True)
    return hashlib.sha256(known.encode()).hexdigest()


def write(path: Path, spec: Spec, shards: Iterable[Shard]) -> None:
    """Write all shards, in order, to `path`; BadInput where the disk is full."""
    import h5py

    with _explained_if_full(path), h5py.File(path, "w", libver=("v108", "v110")) as file:
        _head(file, spec)
        datasets = _empty(file, spec)
        table = file.create_dataset(
            "grasps", (spec.count,), table_type(spec), track_times=False
        )  # fmt: skip
        table.attrs["units"] = np.array([x.encode() for x in units(spec)])
        set_attribute(table, "meanings", json.dumps(MEANINGS))
        digests = file.create_dataset("digests", (count(spec), 32), np.uint8, track_times=False)
        for k, each in enumerate(shards):
            table[k * SIZE : k * SIZE + each.rows.size] = each.rows
            for name, data in each.chunks.items():
                datasets[name].id.write_direct_chunk((k * SIZE, 0), data)
            digests[k] = np.frombuffer(each.digest, np.uint8)


def _head(file: Any, spec: Spec) -> None:
    for key, text in _texts(spec).items():
        set_attribute(file, key, text)
    file.attrs["seed"], file.attrs["border"] = spec.seed, spec.border


def _texts(spec: Spec) -> dict[str, str]:
    """Root attributes that are text."""
    named = {"schema": SCHEMA, "title": spec.title, "specification": spec.text}
    named |= {"groups": json.dumps([group.name for group in spec.groups])}
    named |= {"shapes": json.dumps([group.shape for group in spec.groups])}
    named |= {"roles": json.dumps(ROLES), "meanings": json.dumps(ROOT)}
    return named | {"fingerprint": fingerprint(spec)}


def _empty(file: Any, spec: Spec) -> dict[str, Any]:
    """Create the channels' datasets, to be filled chunk by chunk."""
    times = spec.base.times
    group = file.create_group("channels", track_order=False)
    time = group.create_dataset("time", data=times, dtype="<f8", track_times=False)
    set_attribute(time, "unit", "s")
    time.make_scale("time")
    made = {}
    for name in spec.channels:
        storage = {"chunks": chunk(spec), "shuffle": True, "compression": "gzip"}
        shape = (spec.count, times.size)
        made[name] = group.create_dataset(
            name, shape, STORED, compression_opts=4, track_times=False, **storage
        )
        made[name].dims[1].attach_scale(time)
        set_attribute(made[name], "unit", UNITS[name])
    return made


@contextmanager
def _explained_if_full(path: Path) -> Iterator[None]:
    """Turn a full disk into one line; HDF5 hides the error's number in its message."""
    try:
        yield
    except (OSError, RuntimeError) as error:
        number = getattr(error, "errno", None)
        if number in BODY_FAULTS or any(f"errno = {each}," in str(error) for each in BODY_FAULTS):
            raise BadInput(
                f"cannot write {path.parent}: no space left on the disk; free some and run the "
                "same again: what was simulated is kept"
            ) from None
        raise


def well_headed(path: Path, spec: Spec) -> bool:
    """Return whether times, attributes and units are as `write` leaves them.

    HDF5's own bookkeeping is not checked.
    """
    import h5py

    try:
        with h5py.File(path, "r") as file:
            stored = {key: file.attrs[key] for key in (*_texts(spec), "seed", "border")}
            wanted = {key: text.encode() for key, text in _texts(spec).items()}
            channels = file["channels"]
            return (
                stored == {**wanted, "seed": spec.seed, "border": spec.border}
                and np.array_equal(channels["time"][:], spec.base.times)
                and channels["time"].attrs["unit"] == b"s"
                and all(channels["time"] in channels[n].dims[1].values() for n in spec.channels)
                and all(channels[n].attrs["unit"] == UNITS[n].encode() for n in spec.channels)
                and file["grasps"].attrs["units"].tolist() == [x.encode() for x in units(spec)]
                and file["grasps"].attrs["meanings"] == json.dumps(MEANINGS).encode()
            )
    except (OSError, RuntimeError, KeyError, ValueError, AttributeError):
        return False


def salvaged(path: Path, spec: Spec) -> Iterator[tuple[int, Shard]]:
    """Intact shards of a finished file of the same specification; none where it is another."""
    import h5py

    try:
        with h5py.File(path, "r") as file:
            if file.attrs.get("fingerprint", b"") != fingerprint(spec).encode():
                return
            for k in range(count(spec)):
                if found := _intact(file, spec, k):
                    yield k, found
    except (OSError, RuntimeError, KeyError, ValueError):
        return  # damaged beyond that: earlier shards stand


def _intact(file: Any, spec: Spec, k: int) -> Shard | None:
    try:
        rows = file["grasps"][k * SIZE : min((k + 1) * SIZE, spec.count)]
        read = {n: file["channels"][n].id.read_direct_chunk((k * SIZE, 0)) for n in spec.channels}
        digest = file["digests"][k].tobytes()
    except (OSError, RuntimeError, KeyError, ValueError):
        return None
    found = Shard(rows, {name: bytes(data) for name, (_, data) in read.items()})
    return found if found.digest == digest else None
