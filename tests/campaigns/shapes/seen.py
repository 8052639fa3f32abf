"""Shapes that `hannes begin` was built for."""

import gzip
import json
from pathlib import Path

import numpy as np

from shapes.samples import Samples, shape

HEADER = "time_s,reference_rad,position_rad,current_A\n"


def _csv(samples: Samples, form: str = "{:.3f},{:.6f},{:.6f},{:.4f}\n") -> str:
    return "".join(form.format(*row) for row in samples.rows)


def _written(folder: Path, name: str, text: str) -> list[Path]:
    (folder / name).write_text(text, encoding="utf-8")
    return [folder / name]


@shape(runs=3)
def a_file_a_run(folder: Path, samples: Samples) -> list[Path]:
    """Three plain CSV files."""
    files = []
    for k in range(3):
        files += _written(folder, f"run_{k + 1}.csv", HEADER + _csv(samples.run(k)))
    return files


@shape()
def semicolons_and_decimal_commas(folder: Path, samples: Samples) -> list[Path]:
    """A spreadsheet of a German computer."""
    rows = _csv(samples, "{:.3f};{:.6f};{:.6f};{:.4f}\n").replace(".", ",")
    text = "Zeit [s];Soll [rad];Ist [rad];Strom [A]\n" + rows
    return _written(folder, "messung.csv", text)


@shape()
def tabs_with_units_below(folder: Path, samples: Samples) -> list[Path]:
    """Names, then units, then numbers, divided by tabs, below two lines of title."""
    rows = "".join(
        f"{1e3 * t:.0f}\t{np.degrees(r):.5f}\t{np.degrees(p):.5f}\t{1e3 * i:.1f}\n"
        for t, r, p, i in samples.rows
    )
    head = "Rig 3\n\nTime\tSetpoint\tAngle\tCurrent\nms\tdeg\tdeg\tmA\n"
    return _written(folder, "log.txt", head + rows)


@shape()
def numpy_savetxt(folder: Path, samples: Samples) -> list[Path]:
    """numpy.savetxt with a header, in scientific notation."""
    table = np.array(list(samples.rows))
    file = folder / "log.txt"
    np.savetxt(file, table, header="time_s reference_rad position_rad current_A")
    return [file]


@shape()
def a_data_frame_with_its_index(folder: Path, samples: Samples) -> list[Path]:
    """A pandas frame, its index in a first column without a name, gzipped."""
    rows = "".join(f"{k},{line}\n" for k, line in enumerate(_csv(samples).splitlines()))
    data = ("," + HEADER + rows).encode()
    (folder / "log.csv.gz").write_bytes(gzip.compress(data))
    return [folder / "log.csv.gz"]


@shape(runs=3)
def runs_that_restart(folder: Path, samples: Samples) -> list[Path]:
    """Three runs one below the other: time begins anew."""
    rows = "".join(_csv(samples.run(k)) for k in range(3))
    return _written(folder, "all.csv", HEADER + rows)


@shape(runs=3)
def runs_by_blank_lines_and_headers(folder: Path, samples: Samples) -> list[Path]:
    """A serial monitor: the header is printed anew before every run."""
    return _written(
        folder, "monitor.csv", "\n".join(HEADER + _csv(samples.run(k)) for k in range(3))
    )


@shape(runs=3)
def runs_by_a_label(folder: Path, samples: Samples) -> list[Path]:
    """A column of text names the trial."""
    lines = ["trial," + HEADER]
    for k in range(3):
        lines += [f"T{k + 1},{line}\n" for line in _csv(samples.run(k)).splitlines()]
    return _written(folder, "trials.csv", "".join(lines))


@shape()
def boot_messages_between(folder: Path, samples: Samples) -> list[Path]:
    """A microcontroller that prints warnings among its samples."""
    rows = _csv(samples).splitlines(keepends=True)
    rows[40:40] = ["WARN bus retry 1\n"]
    rows[120:120] = ["WARN bus retry 2\n"]
    return _written(folder, "serial.log", "boot v1.2\n" + HEADER + "".join(rows))


@shape()
def dates_and_times(folder: Path, samples: Samples) -> list[Path]:
    """Stamps of the day in ISO 8601."""
    rows = "".join(
        f"2026-03-03T18:43:{10 + t:09.6f},{r:.6f},{p:.6f},{i:.4f}\n" for t, r, p, i in samples.rows
    )
    return _written(folder, "log.csv", HEADER.replace("time_s", "timestamp") + rows)


@shape()
def microseconds_since_1970(folder: Path, samples: Samples) -> list[Path]:
    """A computer's clock in microseconds."""
    rows = "".join(
        f"{1_772_563_390_000_000 + round(1e6 * t)},{r:.6f},{p:.6f},{i:.4f}\n"
        for t, r, p, i in samples.rows
    )
    return _written(folder, "log.csv", HEADER.replace("time_s", "timestamp") + rows)


@shape()
def npz_arrays(folder: Path, samples: Samples) -> list[Path]:
    """numpy.savez of four arrays."""
    file = folder / "run.npz"
    np.savez(file, time_s=samples.time, reference_rad=samples.reference,
             position_rad=samples.position, current_A=samples.current)  # fmt: skip
    return [file]


@shape(needs="scipy")
def matlab_variables(folder: Path, samples: Samples) -> list[Path]:
    """MATLAB's save of column vectors."""
    import scipy.io

    scipy.io.savemat(folder / "run.mat", {
        "time_s": samples.time[:, None], "reference_rad": samples.reference[:, None],
        "position_rad": samples.position[:, None], "current_A": samples.current[:, None],
    })  # fmt: skip
    return [folder / "run.mat"]


@shape()
def json_lines(folder: Path, samples: Samples) -> list[Path]:
    """An object a line."""
    names = HEADER.strip().split(",")
    lines = [json.dumps(dict(zip(names, row, strict=True))) for row in samples.rows]
    return _written(folder, "run.jsonl", "\n".join(lines) + "\n")


@shape(needs="h5py")
def hdf5_groups(folder: Path, samples: Samples) -> list[Path]:
    """Data sets in a group."""
    import h5py

    with h5py.File(folder / "run.h5", "w") as file:
        group = file.create_group("log")
        group["time_s"], group["reference_rad"] = samples.time, samples.reference
        group["position_rad"], group["current_A"] = samples.position, samples.current
    return [folder / "run.h5"]


@shape(
    answers={
        'unit = "?"  # raw counts: the unit of one count, and how much it is\nscale = "?"':
            'unit = "deg"\nscale = "0.087890625"\noffset = "-6.13592 rad"',
        'unit = "?"': 'unit = "rad"',
    }
)  # fmt: skip
def encoder_counts_that_wrap(folder: Path, samples: Samples) -> list[Path]:
    """An encoder of 4096 counts a turn whose zero is at 4000, a command without a unit."""
    counts = np.round(samples.position * 4096 / (2 * np.pi)).astype(int) + 4000
    rows = "".join(
        f"{t:.3f},{r:.6f},{c % 4096},{i:.4f}\n"
        for (t, r, _, i), c in zip(samples.rows, counts, strict=True)
    )
    return _written(folder, "log.csv", "time_s,goal,position_counts,current_A\n" + rows)


@shape(needs="pyarrow")
def parquet_table(folder: Path, samples: Samples) -> list[Path]:
    """A Parquet file of four columns."""
    import pyarrow
    import pyarrow.parquet

    names = HEADER.strip().split(",")
    columns = [np.array(each) for each in zip(*samples.rows, strict=True)]
    table = pyarrow.table(dict(zip(names, columns, strict=True)))
    pyarrow.parquet.write_table(table, folder / "run.parquet")
    return [folder / "run.parquet"]
