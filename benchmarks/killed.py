"""Runs of `hannes dataset` killed at random moments of their lives: nothing may be lost."""

import hashlib
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from tqdm import tqdm

from benchmarks.harness import Row, must_show

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
    command = [sys.executable, "-m", "hannes", "dataset", "killed.toml", "--out", "killed.h5"]
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    return subprocess.Popen([*command, "--workers", "1"], cwd=folder, **quiet)


def whole(folder: Path) -> tuple[str, float]:
    """Digest of the data set of a run that nobody kills, and its seconds."""
    begun = time.perf_counter()
    start(folder).wait()
    seconds, file = time.perf_counter() - begun, folder / "killed.h5"
    digest = hashlib.sha256(file.read_bytes()).hexdigest()
    file.unlink()
    return digest, seconds


def survived(folder: Path, kills: int) -> tuple[int, int]:
    """Finished files between `kills` kills, and how many of them are not the uninterrupted one's.

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
    return done, wrong


def measure(quick: bool) -> tuple[list[Row], list[Row]]:
    """Kill, and compare every finished file with the uninterrupted one."""
    kills = 10 if quick else 100
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "killed.toml").write_text(SPEC)
        done, wrong = survived(folder, kills)
    row = {"what": f"{kills} kills at random moments", "files_finished": done, "wrong": wrong}
    return [row], [must_show(f"files that {kills} kills changed", wrong, 0, wrong == 0)]
