"""A shard of a data set: some grasps simulated, packed as the file will hold them."""

import functools
import hashlib
import io
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from hannes.core.recording.recording import Recording
from hannes.dataset.empty_closure import STORED as EMPTY_STORED
from hannes.dataset.empty_closure import empty_means, mean_size, numbers_of
from hannes.dataset.sampling import SampledGrasp, emptied, rounded, sample_grasp, sensed
from hannes.dataset.spec import ROLES, Spec, read_spec
from hannes.dataset.touch_limit import approaching, is_limited, limited
from hannes.simulation.batch.simulate_many import simulate_many
from hannes.simulation.sensors import CHANNELS, logged
from hannes.simulation.trajectory import Grasp, Outcome

SIZE = 100  # grasps of a shard, and rows of a chunk of the file
TOUCH, SHARE = 1.0, 0.05  # thresholds of contact: total force [N], and share of its peak
LEVEL = 4  # of deflate
EMPTY = ("current", "position", "reference")  # channels of empty closures
STORED = "<f4"  # seven digits, far below any sensor's noise
OWN = (
    ("number", "<i8", "1"),
    ("noise_seed", "<i8", "1"),
    ("group", "<i4", "1"),
    ("role", "<i1", "1"),
    ("completed", "<i1", "1"),
    ("contact", "<f8", "s"),
    ("release", "<f8", "s"),
    ("peak_force", "<f8", "N"),
)


@dataclass(frozen=True)
class Shard:
    """Rows of the table of grasps, and a deflated chunk of each channel."""

    rows: np.ndarray
    chunks: Mapping[str, bytes]

    @property
    def digest(self) -> bytes:
        """SHA-256 of rows and chunks, in their order."""
        found = hashlib.sha256(self.rows.tobytes())
        for each in self.chunks.values():
            found.update(each)
        return found.digest()

    @property
    def failed(self) -> int:
        """Grasps whose simulation did not end."""
        return int((self.rows["completed"] == 0).sum())

    def packed(self) -> bytes:
        """Bytes of the shard, its digest among them."""
        memory = io.BytesIO()
        arrays = {"rows": self.rows, "digest": np.frombuffer(self.digest, np.uint8)}
        arrays |= {f"chunk {name}": np.frombuffer(x, np.uint8) for name, x in self.chunks.items()}
        np.savez(memory, allow_pickle=False, **arrays)
        return memory.getvalue()

    @staticmethod
    def unpacked(data: bytes) -> "Shard | None":
        """The shard from its bytes, None where they are damaged."""
        try:
            with np.load(io.BytesIO(data), allow_pickle=False) as found:
                names = [name for name in found.files if name.startswith("chunk ")]
                chunks = {name.removeprefix("chunk "): found[name].tobytes() for name in names}
                shard, digest = Shard(found["rows"], chunks), found["digest"].tobytes()
        except Exception:  # a damaged archive raises nearly anything
            return None
        return shard if shard.digest == digest else None


def table_type(spec: Spec) -> np.dtype:
    """Fields of the table of grasps: those of every data set, then a column for each quantity.

    Where hands close on nothing too, `empty` has what that shows of each.
    """
    own = [(name, kind) for name, kind, _ in OWN]
    columns = [(name, "<f8") for name in spec.columns]
    return np.dtype([*own, *columns, *_empty_field(spec)])


def _empty_field(spec: Spec) -> list[tuple[str, str, int]]:
    return [("empty", EMPTY_STORED, numbers_of(spec.empty))] if spec.empty else []


def units(spec: Spec) -> list[str]:
    """Units of the fields."""
    known = [*(unit for _, _, unit in OWN), *(spec.unit(name) for name in spec.columns)]
    return [*known, *("A, then rad" for _ in _empty_field(spec))]


def count(spec: Spec) -> int:
    """Number of shards."""
    return -(-spec.count // SIZE)


def chunk(spec: Spec) -> tuple[int, int]:
    """Shape of a chunk of a channel: grasps, samples."""
    return min(SIZE, spec.count), spec.base.times.size


@functools.lru_cache(maxsize=4)
def _read(text: str) -> Spec:
    return read_spec(text)


def simulated(text: str, number: int) -> bytes:
    """Simulate shard `number` of a resolved specification; runs in any process."""
    return made(_read(text), number).packed()


def made(spec: Spec, number: int) -> Shard:
    """Simulate shard `number`."""
    first = number * SIZE
    sampled = [sample_grasp(spec, k) for k in range(first, min(first + SIZE, spec.count))]
    ran = grasps(spec, sampled, tuple(dict.fromkeys((*spec.channels, "force"))))
    rows = np.zeros(len(sampled), table_type(spec))
    samples = np.zeros((len(spec.channels), *chunk(spec)), STORED)
    shown = _empty_closures(spec, sampled)
    for k, (each, grasp) in enumerate(zip(sampled, ran, strict=True)):
        rows[k] = (*_row(spec, each, grasp), *(shown[k : k + 1] if spec.empty else ()))
        for c, name in enumerate(spec.channels):
            samples[c, k, : grasp.time.size] = sensed(each, grasp, name)
            samples[c, k, grasp.time.size :] = np.nan  # it failed there
    chunks = {name: _deflated(samples[c]) for c, name in enumerate(spec.channels)}
    return Shard(rows, chunks)


def _empty_closures(spec: Spec, sampled: list[SampledGrasp]) -> np.ndarray:
    """What the hands of pressed grasps show while they close on nothing (n, numbers), else NaN."""
    if spec.empty is None:
        return np.zeros((len(sampled), 0))
    found = np.full((len(sampled), numbers_of(spec.empty)), np.nan)
    some = [k for k, each in enumerate(sampled) if each.group.role == "pressed"]
    alone = [emptied(spec, sampled[k]) for k in some]
    size = mean_size(spec.base.sampling)
    for k, each, grasp in zip(some, alone, _simulated(spec, alone, EMPTY), strict=True):
        if grasp.outcome is Outcome.COMPLETED:
            current, position, reference = (sensed(each, grasp, name) for name in EMPTY)
            found[k] = empty_means(current, position, reference, size, found.shape[1])
    return found


def grasps(spec: Spec, sampled: list[SampledGrasp], channels: tuple[str, ...]) -> list[Grasp]:
    """Simulate sampled grasps on one core, keeping these channels."""
    return _simulated(spec, as_closed(spec, sampled), channels)


def as_closed(spec: Spec, sampled: list[SampledGrasp]) -> list[SampledGrasp]:
    """The same, where a command is limited after the touch with the command that results."""
    some = [each for each in sampled if is_limited(each)]
    closing = [approaching(each) for each in some]
    free = _simulated(spec, closing, ("position", "current", "force")) if some else []
    known = {each.number: each for each in limited(some, free)}
    return [known.get(each.number, each) for each in sampled]


def _simulated(spec: Spec, sampled: list[SampledGrasp], channels: tuple[str, ...]) -> list[Grasp]:
    pairs = [(each.hand, each.experiment) for each in sampled]
    how: dict[str, Any] = {"rtol": spec.rtol, "effects": spec.hand.effects, "workers": 1}
    how["progress"] = False  # that of the whole data set is shown
    return list(simulate_many(pairs, channels=channels, **how))


def _row(spec: Spec, sampled: SampledGrasp, grasp: Grasp) -> tuple[Any, ...]:
    ends = touching(grasp.time, grasp["force"])
    group = spec.groups.index(sampled.group)
    own = (sampled.number, sampled.seed, group, ROLES.index(sampled.group.role))
    complete = grasp.outcome is Outcome.COMPLETED
    peak = grasp["force"].max(initial=0.0)
    return (*own, complete, *ends, peak, *(sampled.values[name] for name in spec.columns))


def touching(time: np.ndarray, force: np.ndarray, share: float = SHARE) -> tuple[float, float]:
    """Contact and release [s]: first and last sample above 1 N and `share` of the peak force.

    `time` [s] and total `force` [N] have shape (n,). Below 5 % of the peak, fingers in contact
    wait for the others to close. NaN where nothing is touched.
    """
    found = np.flatnonzero(force > max(TOUCH, share * force.max(initial=0.0)))
    return (float(time[found[0]]), float(time[found[-1]])) if found.size else (np.nan, np.nan)


def _deflated(values: np.ndarray) -> bytes:
    """As HDF5's filters shuffle and deflate leave a chunk."""
    shuffled = np.frombuffer(values.tobytes(), np.uint8).reshape(-1, values.itemsize).T
    return zlib.compress(shuffled.tobytes(), LEVEL)


def recorded(spec: Spec, number: int) -> Recording:
    """Simulate one grasp alone and return its recording, as the data set has it."""
    (sampled,) = as_closed(spec, [sample_grasp(spec, number)])
    (grasp,) = _simulated(spec, [sampled], CHANNELS)
    values = logged(sampled.hand, sampled.experiment, grasp.require())
    steps = {name: sampled.values.get(f"resolution.{name}", 0.0) for name in values.names}
    return values.with_channels(
        {name: rounded(values[name], step) for name, step in steps.items() if step}, {}
    )
