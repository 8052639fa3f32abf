"""Runs of `hannes dataset` killed at random moments of their lives, short of disk, on a cluster of
which a worker dies: nothing may be lost."""

import hashlib
import resource
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from tqdm import tqdm

from benchmarks.harness import Row, must_show

SCARCE = 30_000  # bytes that a file may have, less than a part's
COMMAND = [sys.executable, "-m", "hannes", "dataset", "killed.toml", "--out", "killed.h5"]
QUIET = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
SPEC = """
title = "to be killed"
seed = 1
duration = "0.3 s"
[reference]
kind = "ramp"
points = [["0 s", "0 rad"], ["0.3 s", "5 rad"]]
[values]
"motor.dry_friction" = { spread = "0.05" }
[[grasps]]
shape = "none"
draws = 1500
"""


def start(folder: Path) -> subprocess.Popen[bytes]:
    """Start the run, or let it go on."""
    return subprocess.Popen([*COMMAND, "--workers", "1"], cwd=folder, **QUIET)


def whole(folder: Path) -> tuple[str, float]:
    """Digest of the data set of a run that nobody kills, and its seconds."""
    begun = time.perf_counter()
    start(folder).wait()
    return taken(folder), time.perf_counter() - begun


def taken(folder: Path) -> str:
    """Digest of the data set that is there; it is removed."""
    file = folder / "killed.h5"
    digest = hashlib.sha256(file.read_bytes()).hexdigest() if file.exists() else ""
    file.unlink(missing_ok=True)
    return digest


def scarce(folder: Path, expected: str) -> bool:
    """Whether a run that may not write a whole part says so in a line, and then goes on."""

    def limited() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (SCARCE, SCARCE))

    ended = subprocess.run(
        [*COMMAND, "--workers", "1"], cwd=folder, capture_output=True, text=True,
        preexec_fn=limited, check=False,
    )  # fmt: skip
    reported = ended.returncode == 2 and ended.stderr.strip().count("\n") == 0
    reported = reported and "run the same again" in ended.stderr and not taken(folder)
    start(folder).wait()
    return reported and taken(folder) == expected


def distributed(folder: Path, expected: str) -> bool:
    """Whether a Dask cluster over TCP, one of whose two workers is killed, gives the same file."""
    python = [sys.executable, "-c"]
    entry = "from distributed.cli.dask_{0} import main; main()"
    local = ["--host", "127.0.0.1", "--port", "0", "--dashboard-address", ":0", "--no-dashboard"]
    scheduler = subprocess.Popen(
        [*python, entry.format("scheduler"), *local], stderr=subprocess.PIPE, text=True
    )
    assert scheduler.stderr is not None
    address = next(line.split()[-1] for line in scheduler.stderr if "Scheduler at:" in line)
    how = [address, "--nworkers", "1", "--nthreads", "1", "--no-nanny", "--no-dashboard"]
    workers = [subprocess.Popen([*python, entry.format("worker"), *how], **QUIET) for _ in range(2)]
    run = subprocess.Popen(
        [*COMMAND, "--backend", "dask", "--scheduler", address], cwd=folder, **QUIET
    )
    while not list(folder.glob(".shards*/*.shard")) and run.poll() is None:
        time.sleep(0.02)
    workers[0].kill()
    run.wait()
    for each in (*workers, scheduler):
        each.kill()
        each.wait()
    scheduler.stderr.close()
    return taken(folder) == expected


def survived(folder: Path, kills: int) -> tuple[str, int, int]:
    """Digest of the uninterrupted file, finished files between kills, how many of them differ.

    A run goes on until it has finished; then the next begins from nothing.
    """
    expected, life = whole(folder)
    rng, done, wrong, killed = np.random.default_rng(1), 0, 0, 0
    bar = tqdm(total=kills, desc="kills", leave=False)
    while killed < kills or not (folder / "killed.h5").exists():
        run = start(folder)
        try:
            run.wait(rng.uniform(0.0, life) if killed < kills else None)
        except subprocess.TimeoutExpired:
            run.send_signal(signal.SIGKILL)
            run.wait()
            killed += 1
            bar.update()
        if (file := folder / "killed.h5").exists():
            done += 1
            wrong += hashlib.sha256(file.read_bytes()).hexdigest() != expected
            if killed < kills:
                file.unlink()
    bar.close()
    (folder / "killed.h5").unlink()
    return expected, done, wrong


def measure(quick: bool) -> tuple[list[Row], list[Row]]:
    """Kill, and compare every finished file with the uninterrupted one."""
    kills = 10 if quick else 100
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "killed.toml").write_text(SPEC)
        expected, done, wrong = survived(folder, kills)
        full, cluster = scarce(folder, expected), distributed(folder, expected)
    row = {"what": f"{kills} kills at random moments", "files_finished": done, "wrong": wrong}
    return [row], [
        must_show(f"files that {kills} kills changed", wrong, 0, wrong == 0),
        must_show("a full disk is reported in a line, and the same file made after", full, 1, full),
        must_show("a cluster that loses a worker makes the same file", cluster, 1, cluster),
    ]
