"""`hannes dataset`: simulate a specification's grasps on all cores or a cluster, losing nothing.

Each shard goes to a file of its own as soon as it is done, so that a run that was ended in any way
resumes where it was. The data set itself appears under its name only when it is whole.
"""

import functools
import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from hannes.core.errors import BadInput, ComputationFailed, Interrupted
from hannes.core.io.atomic_files import write_bytes
from hannes.core.io.outputs import reserved
from hannes.core.io.parent import end_with
from hannes.core.trust.consent import grant, granted
from hannes.dataset import hdf5_file
from hannes.dataset.sampling import sample_grasp
from hannes.dataset.shard import SIZE, Shard, count, simulated
from hannes.dataset.spec import Spec, read_spec

BACKENDS = ("local", "dask")
ANSWER = 5  # s, timeout of a scheduler
TRIES = 3  # times that workers may die before a run gives up


def make(
    spec: Spec,
    out: str | Path,
    *,
    backend: str = "local",
    scheduler: str = "",
    workers: int | None = None,
    progress: bool | None = None,
    force: bool = False,
) -> dict[str, Any]:
    """Write the data set to `out`; return counts: grasps, shards, shards simulated now, failures.

    `workers` are local processes (default: all cores); backend "dask" uses the cluster of the
    scheduler at that address. The bytes are the same for any of them. `progress` shows a bar on
    standard error, by default on a terminal. `force`: a file that another command wrote is
    replaced, too. Raises BadInput for what cannot be made or written, ComputationFailed where
    workers keep dying.
    """
    if Path(out).suffix not in (".h5", ".hdf5"):
        raise BadInput(f"{out}: expected a file named .h5 or .hdf5 for the data set")
    with reserved("dataset", [out], spec.inputs, force=force):
        _check_cells(spec)
        shards = Shards(Path(os.path.realpath(out)), spec)
        if missing := shards.missing():
            _simulate(spec, shards, missing, _how(backend, scheduler, workers), progress)
        shards.finish()
    return {
        "out": str(out),
        "grasps": spec.count,
        "shards": count(spec),
        "shards_simulated": len(missing),
        "failed": shards.failed,
    }


def _check_cells(spec: Spec) -> None:
    """Sample the first grasp of every cell of the design, so that a bad one is reported at once."""
    first = 0
    for group in spec.groups:
        for cell in range(min(group.cells, 1000)):
            sample_grasp(spec, first + cell * group.draws)
        first += group.count


class Shards:
    """Shards that are done, each in a file of a folder beside the data set."""

    def __init__(self, target: Path, spec: Spec) -> None:
        self.target, self.spec = target, spec
        self.folder = target.parent / f".shards-{hdf5_file.fingerprint(spec)[:16]}.{target.name}"
        self.whole, self.failed = False, 0

    def path(self, k: int) -> Path:
        """File of shard `k`."""
        return self.folder / f"{k:06d}.shard"

    def read(self, k: int) -> Shard | None:
        """A shard, None where it is missing or damaged."""
        try:
            return Shard.unpacked(self.path(k).read_bytes())
        except OSError:
            return None

    def missing(self) -> list[int]:
        """Numbers of the shards still to be simulated; intact ones of a damaged file are kept."""
        kept = {k for k in range(count(self.spec)) if self.read(k)}
        if self.target.exists():
            sound = [shard.failed for _, shard in hdf5_file.salvaged(self.target, self.spec)]
            self.whole, self.failed = len(sound) == count(self.spec), sum(sound)
            self.whole = self.whole and hdf5_file.well_headed(self.target, self.spec)
            if self.whole:
                return []
            for k, shard in hdf5_file.salvaged(self.target, self.spec):
                if k not in kept:
                    self.write(k, shard.packed())
                    kept.add(k)
        return [k for k in range(count(self.spec)) if k not in kept]

    def write(self, k: int, data: bytes) -> None:
        """Keep a shard; BadInput where the disk is full."""
        try:
            write_bytes(self.path(k), data)
        except BadInput as error:
            raise BadInput(f"{error}; then run the same again: what is done is kept") from None

    def finish(self) -> None:
        """Join the shards under the data set's name, and remove them."""
        if not self.whole:
            self.failed = 0
            temporary = self.folder / "whole.h5"
            hdf5_file.write(temporary, self.spec, self._all())
            _flush(temporary)
            os.replace(temporary, self.target)
        shutil.rmtree(self.folder, ignore_errors=True)

    def _all(self) -> Iterator[Shard]:
        for k in range(count(self.spec)):
            shard = self.read(k)
            if shard is None:
                raise ComputationFailed(
                    f"shard {k} of {self.target.name} was damaged; run it again"
                )
            self.failed += shard.failed
            yield shard


def _flush(path: Path) -> None:
    with path.open("rb") as stream:
        os.fsync(stream.fileno())


def _simulate(
    spec: Spec, shards: Shards, missing: list[int], how: Any, progress: bool | None
) -> None:
    """Simulate shards in any order; those of workers that died go to others."""
    from hannes.core.io.progress import progress_bar

    _make_ready(spec)
    left = dict.fromkeys(missing)
    bar = progress_bar(
        total=len(missing) * SIZE, desc="grasps", disable=_quiet(progress), delay=1.0
    )
    with bar, how() as parallel:
        for turn in range(TRIES):
            try:
                for k, data in parallel(_tasks(spec, list(left))):
                    shards.write(k, data)
                    del left[k]
                    bar.update(SIZE)
            except KeyboardInterrupt:
                raise Interrupted("interrupted; the same command goes on where it was") from None
            except Exception as error:
                if not _died(error) or turn == TRIES - 1:
                    raise _explained(error, len(left)) from error
            if not left:
                return


def _quiet(progress: bool | None) -> bool | None:
    """tqdm takes None for "only on a terminal"."""
    return None if progress is None else not progress


def _tasks(spec: Spec, numbers: list[int]) -> Iterator[Any]:
    from joblib import delayed

    wanted, may_run = hdf5_file.fingerprint(spec), granted()
    return (delayed(numbered)(spec.text, k, wanted, may_run) for k in numbers)


def numbered(
    text: str, number: int, wanted: str, may_run: tuple[str, ...] = ()
) -> tuple[int, bytes]:
    """A shard with its number; BadInput where this process is of another version than `wanted`.

    `may_run`: digests of Python that the user consented to.
    """
    grant(may_run)
    if _fingerprint(text) != wanted:
        raise BadInput(
            "a worker has another version of hannes, Python or a package than this machine: "
            "install the same on all, and start workers anew after that"
        )
    return number, simulated(text, number)


@functools.lru_cache(maxsize=4)
def _fingerprint(text: str) -> str:
    return hdf5_file.fingerprint(read_spec(text))


def _make_ready(spec: Spec) -> None:
    """Compile once before workers do it all at a time."""
    from hannes.simulation.compiled_call import say_when_compiling

    say_when_compiling(spec.hand.compiled(spec.hand.effects), "grasps")
    simulated(spec.text, 0)


def _died(error: Exception) -> bool:
    return type(error).__name__ in ("TerminatedWorkerError", "KilledWorker", "BrokenProcessPool")


def _explained(error: Exception, left: int) -> Exception:
    if not _died(error):
        return error
    return ComputationFailed(
        f"workers died {TRIES} times ({left} shards left), out of memory?; run the same again with "
        "fewer --workers: what is done is kept"
    )


def _how(backend: str, scheduler: str, workers: int | None) -> Any:
    """A context that gives joblib's `Parallel` on this machine or on a cluster."""
    if backend not in BACKENDS:
        raise BadInput(f'backend "{backend}": expected one of {", ".join(BACKENDS)}')
    if workers is not None and workers < 1:
        raise BadInput(f"workers = {workers}: expected 1 or more")
    if (backend == "dask") != bool(scheduler):
        raise BadInput("--backend dask goes with --scheduler ADDRESS, such as tcp://host:8786")
    return (lambda: _cluster(scheduler)) if backend == "dask" else (lambda: _local(workers))


@contextmanager
def _local(workers: int | None) -> Iterator[Any]:
    from joblib import Parallel
    from joblib.externals.loky import get_reusable_executor

    try:
        yield Parallel(
            n_jobs=workers or -1,
            batch_size=1,
            return_as="generator_unordered",
            initializer=end_with,
            initargs=(os.getpid(),),
        )
    except BaseException:  # an interrupt too: nobody waits for what is still under way
        get_reusable_executor().shutdown(kill_workers=True)
        raise


@contextmanager
def _cluster(address: str) -> Iterator[Any]:
    from joblib import Parallel, parallel_config

    try:
        from distributed import Client
    except ImportError:
        raise BadInput(
            "the dask backend needs the package distributed: pip install '.[cluster]' in a checkout"
        ) from None
    try:
        client = Client(address, timeout=ANSWER)
    except (OSError, ValueError, TimeoutError) as error:
        raise BadInput(f"no Dask scheduler answers at {address}: {error}") from None
    with client, parallel_config(backend="dask", wait_for_workers_timeout=60):
        yield Parallel(batch_size=1, return_as="generator_unordered")
