"""A long log: ten minutes at 1 kHz with eight columns, converted and checked.

Processor time against pandas' `read_csv` of the same file, in turns in one process, imports not
counted; most memory of a process that converts and checks alone.
"""

import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from benchmarks.harness import Row, interval, main, must_show, peak_mib

RATE, LASTING, QUICK = 1000, 600, 30  # Hz, s
TIMES, MEMORY = 8.0, 500.0  # of read_csv, MiB
COLUMNS = ("reference_rad", "position_rad", "current_A", "duty_1", "supply_V", "force_N")
COLUMNS += ("sensor_N",)


def log(folder: Path, lasting: int) -> tuple[Path, Path]:
    """Write the log and its mapping; a hand that closes and opens every five seconds."""
    rng = np.random.default_rng(1)
    stamps = np.arange(RATE * lasting + 1) / RATE
    asked, moved = (5.0 - 5.0 * np.cos(0.4 * np.pi * (stamps - lag)) for lag in (0.0, 0.06))
    drive = 0.5 * np.sin(0.4 * np.pi * stamps) + 0.01 * rng.standard_normal(stamps.size)
    supply = 12.0 + 0.01 * rng.standard_normal(stamps.size)
    push = np.maximum(drive, 0.0)
    table = (stamps, asked, moved, drive, 0.1 * drive, supply, 10.0 * push, 9.0 * push)
    form = ["%.3f"] + ["%.6f"] * len(COLUMNS)
    np.savetxt(folder / "log.csv", np.column_stack(table), form, ",",
               header=",".join(("t", *COLUMNS)), comments="")  # fmt: skip
    lines = ['[time]\ncolumn = "t"\nunit = "s"']
    for name in COLUMNS:
        channel, _, unit = name.rpartition("_")
        lines.append(f'[channels.{channel}]\ncolumn = "{name}"\nunit = "{unit}"')
    (folder / "map.toml").write_text("\n".join(lines) + "\n", encoding="utf-8")
    return folder / "log.csv", folder / "map.toml"


def used(file: Path, mapping: Path) -> int:
    """Convert and check; the number of findings."""
    from hannes.campaigns.check import check
    from hannes.campaigns.convert import convert
    from hannes.plants.protocol import shipped_plant

    (made,) = convert([file], mapping)
    return len(check(made.recording, shipped_plant("hand")))


def seconds(call: Callable[[], object]) -> float:
    """Processor time of a call."""
    start = time.process_time()
    call()
    return time.process_time() - start


def measure(quick: bool) -> tuple[list[Row], list[Row]]:
    """Ratios of times in turns, and memory."""
    import pandas

    with tempfile.TemporaryDirectory() as folder:
        file, mapping = log(Path(folder), QUICK if quick else LASTING)
        used(*log(Path(folder), 2))  # imports
        file, mapping = log(Path(folder), QUICK if quick else LASTING)
        turns = [
            (seconds(lambda: pandas.read_csv(file)), seconds(lambda: used(file, mapping)))
            for _ in range(2 if quick else 5)
        ]
        command = [sys.executable, "-m", "benchmarks.long_log", "--alone", str(file), str(mapping)]
        peak = float(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
    ratios = [own / other for other, own in turns]
    value = float(np.median(ratios))
    rows = [{"turn": k, "read_csv_s": a, "hannes_s": b} for k, (a, b) in enumerate(turns, 1)]
    ratio = must_show("convert and check, in read_csv's time", value, TIMES, value <= TIMES)
    return rows, [
        ratio | interval(ratios),
        must_show("most memory [MiB]", peak, MEMORY, peak <= MEMORY),
    ]


if __name__ == "__main__":
    if "--alone" in sys.argv:
        used(*map(Path, sys.argv[2:]))
        print(peak_mib())
    else:
        main(__doc__, "long_log", measure)
