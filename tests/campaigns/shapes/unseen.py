"""File shapes by somebody who saw only what they should be."""

import json
from datetime import datetime, timedelta
from pathlib import Path

import numpy as np

from shapes.samples import Samples, shape


@shape()
def german_excel_csv(folder: Path, samples: Samples) -> list[Path]:
    """A German Excel's "save as CSV".

    Semicolons, decimal commas, cp1252, CRLF, a title block, German names.
    """
    lines = [
        "Prüfstand Handprothese;;;",
        "Prüfer: Müller;;;",
        "Datum: 14.03.2023 10:22;;;",
        ";;;",
        "Zeit [s];Sollwert [rad];Istwert [rad];Strom [A]",
    ]
    lines += [f"{t:.3f};{r:.5f};{p:.5f};{i:.4f}".replace(".", ",") for t, r, p, i in samples.rows]
    file = folder / "Messung 14.03.2023.csv"
    file.write_bytes(("\r\n".join(lines) + "\r\n").encode("cp1252"))
    return [file]


@shape()
def arduino_serial_monitor(folder: Path, samples: Samples) -> list[Path]:
    """Copied out of the Arduino IDE's serial monitor.

    PC stamps, label:value pairs, boot chatter, a half first line.
    """
    clock = datetime(2023, 5, 2, 16, 7, 41, 112000)
    rng = np.random.default_rng(3)
    lines = ["16:07:40.871 -> 0213,I_mA:12", "16:07:40.902 -> Motor controller v1.3 ready"]
    for t, r, p, i in samples.rows:
        clock_now = clock + timedelta(seconds=float(t) + 0.003 * rng.random())
        stamp = clock_now.strftime("%H:%M:%S.") + f"{clock_now.microsecond // 1000:03d}"
        lines.append(
            f"{stamp} -> t_ms:{round(1000 * t)},ref_rad:{r:.5f},pos_rad:{p:.5f},I_mA:{1000 * i:.1f}"
        )
    file = folder / "serial.txt"
    file.write_text("\n".join(lines) + "\n")
    return [file]


@shape()
def labview_lvm(folder: Path, samples: Samples) -> list[Path]:
    """LabVIEW's "Write To Measurement File".

    Tabs, two headers, units in the channel header, one X column, a comment column.
    """
    n = len(samples.time)
    head = [
        "LabVIEW Measurement",
        "Writer_Version\t2",
        "Reader_Version\t2",
        "Separator\tTab",
        "Decimal_Separator\t.",
        "Multi_Headings\tNo",
        "X_Columns\tOne",
        "Time_Pref\tRelative",
        "Operator\tlab",
        "Date\t2022/11/08",
        "Time\t09:41:17.5130000",
        "***End_of_Header***\t",
        "",
        "Channels\t3\t\t\t",
        f"Samples\t{n}\t{n}\t{n}\t",
        "Date\t2022/11/08\t2022/11/08\t2022/11/08\t",
        "Time\t09:41:17.5130000\t09:41:17.5130000\t09:41:17.5130000\t",
        "Y_Unit_Label\trad\trad\tA\t",
        "X_Dimension\tTime\tTime\tTime\t",
        "X0\t0.0000000000000000E+0\t0.0000000000000000E+0\t0.0000000000000000E+0\t",
        "Delta_X\t0.005000\t0.005000\t0.005000\t",
        "***End_of_Header***\t\t\t\t",
        "X_Value\tReference\tPosition\tCurrent\tComment",
    ]
    body = [f"{t:.6f}\t{r:.6f}\t{p:.6f}\t{i:.6f}" for t, r, p, i in samples.rows]
    file = folder / "test_001.lvm"
    file.write_bytes(("\r\n".join(head + body) + "\r\n").encode("ascii"))
    return [file]


@shape(needs="scipy")
def simulink_structure_with_time(folder: Path, samples: Samples) -> list[Path]:
    """A Simulink scope's "Structure With Time" in a MAT file.

    Time, signals(k).values, signals(k).label.
    """
    from scipy.io import savemat

    signals = np.zeros(
        (1, 3),
        dtype=[
            ("values", object),
            ("dimensions", object),
            ("label", object),
            ("title", object),
            ("plotStyle", object),
        ],
    )
    channels = [
        (samples.reference, "reference [rad]"),
        (samples.position, "position [rad]"),
        (samples.current, "current [A]"),
    ]
    for k, (values, label) in enumerate(channels):
        signals[0, k] = (
            np.asarray(values, dtype=float)[:, None],
            1.0,
            label,
            "",
            np.array([[0.0, 0.0]]),
        )
    file = folder / "scope.mat"
    savemat(
        file,
        {
            "ScopeData": {
                "time": np.asarray(samples.time, dtype=float)[:, None],
                "signals": signals,
                "blockName": "HandRig/Scope",
            }
        },
    )
    return [file]


@shape()
def twincat_scope_csv(folder: Path, samples: Samples) -> list[Path]:
    """Beckhoff's TwinCAT Scope export.

    A block of properties over each channel, and each channel with its own time in ms.
    """
    names = [("Reference", "rad"), ("Position", "rad"), ("Current", "A")]
    head = [
        "Name\tScope Project",
        "File\tC:\\Scope\\hand.tcscopex",
        "Starttime of export\t133234567890000000\t14:03:09.000",
        "Endtime of export\t133234567902000000\t14:03:10.200",
        "",
        "\t".join(f"Name\t{name}" for name, _ in names),
        "\t".join(f"SymbolName\tMAIN.f{name}" for name, _ in names),
        "\t".join("Data-Type\tREAL64" for _ in names),
        "\t".join("SampleTime[ms]\t5" for _ in names),
        "\t".join(f"Unit\t{unit}" for _, unit in names),
        "\t".join("Offset\t0" for _ in names),
        "\t".join("ScaleFactor\t1" for _ in names),
        "",
    ]
    body = []
    for t, r, p, i in samples.rows:
        ms = f"{round(1000 * t)}"
        body.append("\t".join(f"{ms}\t{value:.6f}" for value in (r, p, i)))
    file = folder / "Scope_export.csv"
    file.write_bytes(("\r\n".join(head + body) + "\r\n").encode("ascii"))
    return [file]


@shape(needs="pyarrow")
def influx_long_parquet(folder: Path, samples: Samples) -> list[Path]:
    """A database's export as long table.

    One row a value, UTC stamps, the signal's name and unit in columns.
    """
    import pandas as pd

    stamps = pd.Timestamp("2024-02-06T13:30:00Z") + pd.to_timedelta(
        np.round(1000 * np.asarray(samples.time)), unit="ms"
    )
    parts = [
        pd.DataFrame(
            {
                "timestamp": stamps,
                "signal": name,
                "value": np.asarray(values, dtype=float),
                "unit": unit,
            }
        )
        for name, values, unit in (
            ("current", samples.current, "A"),
            ("position", samples.position, "rad"),
            ("reference", samples.reference, "rad"),
        )
    ]
    table = (
        pd.concat(parts).sort_values(["timestamp", "signal"], kind="stable").reset_index(drop=True)
    )
    file = folder / "export.parquet"
    table.to_parquet(file)
    return [file]


@shape(runs=3)
def telemetry_json_lines(folder: Path, samples: Samples) -> list[Path]:
    """A telemetry (MQTT) subscriber's dump, a file a run.

    One JSON object a line, epoch milliseconds, nested values.
    """
    files = []
    for k in range(3):
        run = samples.run(k)
        begin = 1_709_300_000_000 + 60_000 * k
        lines = [
            json.dumps(
                {
                    "topic": "rig/hand/telemetry",
                    "ts_ms": begin + round(1000 * float(t)),
                    "payload": {
                        "reference_rad": round(float(r), 6),
                        "position_rad": round(float(p), 6),
                        "current_A": round(float(i), 6),
                    },
                }
            )
            for t, r, p, i in run.rows
        ]
        file = folder / f"run_{k + 1:02d}.jsonl"
        file.write_text("\n".join(lines) + "\n")
        files.append(file)
    return files


@shape(needs="openpyxl")
def workbook_with_info_sheet(folder: Path, samples: Samples) -> list[Path]:
    """A technician's workbook.

    An info sheet first, the data on the second with units in a row of their own, degrees and
    mA.
    """
    from openpyxl import Workbook

    book = Workbook()
    info = book.active
    info.title = "Info"
    for row in (
        ("Test", "Hand, step response"),
        ("Operator", "J. Smith"),
        ("Date", datetime(2023, 9, 21)),
        ("Sample rate", "200 Hz"),
    ):
        info.append(row)
    data = book.create_sheet("Data")
    data.append(("Time", "Reference", "Position", "Current"))
    data.append(("ms", "deg", "deg", "mA"))
    for t, r, p, i in samples.rows:
        data.append(
            (round(1000 * float(t), 3), float(np.degrees(r)), float(np.degrees(p)), 1000 * float(i))
        )
    file = folder / "Test 7.xlsx"
    book.save(file)
    return [file]


@shape(answers={'unit = "?"': 'unit = "A"'})
def rostopic_echo_csv(folder: Path, samples: Samples) -> list[Path]:
    """`rostopic echo -b run.bag -p /hand/state`.

    "%time", "field." names, stamps in ns, a frame's name, a current without unit.
    """
    lines = [
        "%time,field.header.seq,field.header.stamp,field.header.frame_id,"
        "field.reference_rad,field.position_rad,field.current"
    ]
    for k, (t, r, p, i) in enumerate(samples.rows):
        stamp = 1_650_012_345_000_000_000 + round(1000 * float(t)) * 1_000_000
        arrival = stamp + 180_000 + 40_000 * (k * 7 % 5)
        lines.append(f"{arrival},{1204 + k},{stamp},hand_base,{r:.9g},{p:.9g},{i:.9g}")
    file = folder / "hand_state.csv"
    file.write_text("\n".join(lines) + "\n")
    return [file]


@shape(runs=3)
def npz_trials_stacked(folder: Path, samples: Samples) -> list[Path]:
    """A Python rig's np.savez.

    One time vector, the channels as trials by samples, and some settings beside them.
    """
    runs = [samples.run(k) for k in range(3)]
    file = folder / "trials.npz"
    np.savez(
        file,
        time_s=np.asarray(runs[0].time),
        reference_rad=np.asarray(runs[0].reference),
        position_rad=np.stack([run.position for run in runs]),
        current_A=np.stack([run.current for run in runs]),
        fs_hz=200.0,
        kp=np.float32(12.5),
        operator="anna",
    )
    return [file]
