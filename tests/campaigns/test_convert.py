"""Foreign files through a mapping: what comes out is what was measured, whatever it was called."""

import json
import textwrap

import h5py
import numpy as np
import pytest
import scipy.io
from real_finger import rh56_files

from hannes.campaigns import third_party
from hannes.campaigns.convert import convert, write
from hannes.campaigns.foreign.mapping_file import read_mapping
from hannes.commands.cli import main
from hannes.commands.cli_recordings import EXAMPLES
from hannes.core.errors import BadInput, MissingRecording
from hannes.core.io.result_marks import CONVERTED
from hannes.core.recording.recording import Recording
from hannes.simulation.experiment.reader import parse_experiment

TIME = np.round(np.arange(0.0, 1.0, 0.001), 6)
POSITION = np.round(4.0 * (1.0 - np.cos(2.0 * np.pi * TIME)), 9)
CURRENT = np.round(0.3 * np.sin(2.0 * np.pi * TIME), 9)
DEGREE = np.pi / 180.0

PLAIN = """
[time]
column = "t"
unit = "s"
[channels.position]
column = "pos"
unit = "rad"
[channels.current]
column = "cur"
unit = "A"
"""


def saved(folder, text, name="map.toml"):
    (folder / name).write_text(text, encoding="utf-8")
    return folder / name


def table(folder, header, rows, name="log.csv", join=","):
    lines = [header, *(join.join(row) for row in rows)]
    (folder / name).write_text("\n".join(lines) + "\n", encoding="utf-8")
    return folder / name


def plain_rows(time=TIME):
    columns = zip(time, POSITION, CURRENT, strict=True)
    return [[f"{t:.9g}", f"{x:.12g}", f"{i:.12g}"] for t, x, i in columns]


def one(folder, file, mapping):
    (made,) = convert([file], saved(folder, mapping))
    return made


def test_degrees_of_the_motor_side_reversed_in_a_german_table(tmp_path):
    """Decimal commas, semicolons, comments, a line of units, milliseconds, milliamperes."""
    counts = -(POSITION * 19.0 / DEGREE - 7.0)
    rows = [
        [f"{1e3 * t:.6f}".replace(".", ","), f"{c:.12f}".replace(".", ","), f"{1e3 * i:.9f}"]
        for t, c, i in zip(TIME, counts, CURRENT, strict=True)
    ]
    rows = [[a, b, c.replace(".", ",")] for a, b, c in rows]
    lines = ["# made by hand", "Zeit;Winkel;Strom", "ms;Grad;mA", "# second comment"]
    lines += [";".join(row) for row in rows]
    file = tmp_path / "log.txt"
    file.write_text("\r\n".join(lines) + "\r\n", encoding="latin-1")
    made = one(
        tmp_path,
        file,
        """
        [text]
        decimal = ","
        comment = "#"
        header = 2
        first = 4
        encoding = "latin-1"
        [time]
        column = "Zeit"
        unit = "ms"
        offset = "0.25 s"
        [channels.position]
        column = "Winkel"
        unit = "deg"
        side = "motor"
        reversed = true
        offset = "0.00643 rad"
        [channels.current]
        column = 3
        unit = "mA"
        """,
    )
    assert made.recording.units == {"time": "s", "position": "rad", "current": "A"}
    np.testing.assert_allclose(made.recording.time, TIME + 0.25, atol=1e-9)
    shifted = POSITION - 7.0 * DEGREE / 19.0 + 0.00643
    np.testing.assert_allclose(made.recording["position"], shifted, atol=1e-9)
    np.testing.assert_allclose(made.recording["current"], CURRENT, atol=1e-9)
    assert made.report["channels"]["position"]["factor"] == pytest.approx(-DEGREE / 19.0)


@pytest.mark.parametrize("delimiter", [",", ";", "\t", "  "])
def test_the_delimiter_is_found_out(tmp_path, delimiter):
    header = delimiter.join(["t", "pos", "cur"])
    made = one(tmp_path, table(tmp_path, header, plain_rows(), join=delimiter), PLAIN)
    assert np.array_equal(made.recording["position"], POSITION)


def test_lines_may_end_in_a_tab(tmp_path):
    rows = [[*row, ""] for row in plain_rows()]
    made = one(tmp_path, table(tmp_path, "t\tpos\tcur", rows, join="\t"), PLAIN)
    assert np.array_equal(made.recording["current"], CURRENT)


def test_a_dataset_may_have_a_dot_in_its_name(tmp_path):
    with h5py.File(tmp_path / "log.h5", "w") as file:
        file["t"], file["motor.current"] = TIME, CURRENT
    mapping = """
        time = { column = "t", unit = "s" }
        channels.current = { column = "motor.current", unit = "A" }
        """
    made = one(tmp_path, tmp_path / "log.h5", mapping).recording
    assert np.array_equal(made["current"], CURRENT)


def test_an_experiment_with_a_recorded_reference_needs_no_other_file(tmp_path):
    """Nor does it matter from where the command is given."""
    Recording({"time": TIME, "reference": 3.0 * TIME}, {"time": "s", "reference": "rad"}).write(
        tmp_path / "asked.csv"
    )
    saved(tmp_path, '[reference]\nkind = "file"\npath = "asked.csv"\n', "mine.toml")
    mapping = 'experiment = "mine.toml"\n' + PLAIN
    made = one(tmp_path, table(tmp_path, "t,pos,cur", plain_rows()), mapping)
    reference = parse_experiment(made.recording.experiment).reference
    assert np.array_equal(reference.knots, [TIME, 3.0 * TIME])


def test_hdf5_matlab_and_csv_give_one_recording(tmp_path):
    with h5py.File(tmp_path / "log.h5", "w") as file:
        file["run/clock"] = TIME
        file["run/data"] = np.array([POSITION, CURRENT])
    scipy.io.savemat(
        tmp_path / "log.mat", {"run": {"clock": TIME, "data": np.array([POSITION, CURRENT]).T}}
    )
    mapping = """
        time = { column = "run/clock", unit = "s" }
        channels.position = { column = "run/data", index = 1, unit = "rad" }
        channels.current = { column = "run.data", index = 2, unit = "A" }
        """
    text = one(tmp_path, table(tmp_path, "t,pos,cur", plain_rows()), PLAIN).recording
    for name in ("log.h5", "log.mat"):
        made = one(tmp_path, tmp_path / name, mapping).recording
        for channel in ("time", "position", "current"):
            assert np.array_equal(made[channel], text[channel])


def test_emps_by_the_shipped_mapping_is_what_scipy_reads():
    try:
        folder = third_party.folder("emps")
    except MissingRecording as missing:
        pytest.skip(f"needs the EMPS recordings: {missing}")
    file = folder / "DATA_EMPS_PULSES.mat"
    (made,), known = convert([file], "emps-pulses"), scipy.io.loadmat(file, squeeze_me=True)
    names = {"time": "t", "reference": "qg", "position": "qm", "drive": "vir", "pulses": "pulses_N"}
    assert set(made.recording.channels) == set(names)
    assert all(np.array_equal(made.recording[name], known[names[name]]) for name in names)


FINGER = """
from hannes.plants.plain import PlainPlant


class Finger(PlainPlant):
    name = "finger"
    channels = {"time": "s", "angle": "1", "force": "N"}
    judged = ("force",)
"""


def test_trials_of_a_real_finger_by_a_mapping(tmp_path):
    """RH56: gzip, twenty trials in a file, raw counts of force, a plant of one's own."""
    files = rh56_files("middlefinger_speed1000_force500_*.csv.gz")
    (tmp_path / "finger.py").write_text(FINGER, encoding="utf-8")
    mapping = """
        plant = "finger:Finger"
        split = "Trial_Index"
        time = { column = "Trial_Elapsed_s", unit = "s" }
        channels.angle = { column = "Middle_Angle", unit = "1" }
        [channels.force]
        column = "Middle_Force_g"
        scale = 0.006452
        unit = "N"
        offset = "18 mN"
        """
    made = convert(files, saved(tmp_path, mapping), trust=True)
    assert len(made) == 20 and all(each.recording.plant == "finger" for each in made)
    assert all(each.recording["angle"].max() <= 1000.0 for each in made)
    peak = max(each.recording["force"].max() for each in made)
    assert 5.0 < peak < 15.0  # N; counts up to some 1700
    assert made[0].report["rows"][0] == 1 and made[1].report["rows"][0] > made[0].report["rows"][1]


def test_missing_values_drop_their_row_or_are_filled(tmp_path):
    rows = plain_rows()
    rows[10][1], rows[11][2], rows[12][2], rows[13][1] = "", "-999", "n/a", "NaN"
    file = table(tmp_path, "t,pos,cur", rows)
    mapping = 'missing = [-999, "n/a"]\n' + PLAIN
    made = one(tmp_path, file, mapping)
    kept = np.delete(np.arange(TIME.size), [10, 11, 12, 13])
    assert np.array_equal(made.recording.time, TIME[kept]) and made.report["dropped_rows"] == 4
    made = one(tmp_path, file, mapping + 'fill = "linear"\n')
    assert made.report["dropped_rows"] == 2 and made.report["filled_values"] == {"current": 2}
    between = np.interp(TIME[11:13], TIME[[10, 13]], CURRENT[[10, 13]])
    np.testing.assert_allclose(made.recording["current"][10:12], between, rtol=1e-9)
    made = one(tmp_path, file, mapping + 'fill = "hold"\n')
    assert made.recording["current"][10:12].tolist() == [CURRENT[10]] * 2


def test_runs_are_split_where_a_column_changes(tmp_path):
    rows = [[*row, str(1 + k // 400)] for k, row in enumerate(plain_rows())]
    file = table(tmp_path, "t,pos,cur,trial", rows)
    mapping = saved(
        tmp_path, 'split = "trial"\n' + PLAIN.replace("[time]", "[time]\nfrom_zero=true")
    )
    made = convert([file], mapping)
    assert [each.name for each in made] == ["log-001", "log-002", "log-003"]
    assert [len(each.recording) for each in made] == [400, 400, 200]
    assert all(each.recording.time[0] == 0.0 for each in made)
    paths = write(made, tmp_path / "runs")
    assert [path.name for path in paths] == ["log-001.h5", "log-002.h5", "log-003.h5"]
    assert Recording.read(paths[2]) == made[2].recording


def test_clock_times_and_a_sampling_rate(tmp_path):
    stamps = [f"2026-03-03 18:43:{second + 1:09.6f}" for second in TIME]
    rows = [[stamp, *row[1:]] for stamp, row in zip(stamps, plain_rows(), strict=True)]
    iso = PLAIN.replace('unit = "s"', 'format = "iso"', 1)
    made = one(tmp_path, table(tmp_path, "t,pos,cur", rows), iso)
    np.testing.assert_allclose(made.recording.time, TIME, atol=2e-6)
    rate = PLAIN.replace('column = "t"\nunit = "s"', 'sampling = "500 Hz"', 1)
    made = one(tmp_path, table(tmp_path, "t,pos,cur", rows), rate)
    np.testing.assert_allclose(made.recording.time, 2.0 * TIME, atol=1e-12)


def test_resampling_keeps_gaps_and_means(tmp_path):
    late = np.where(np.arange(TIME.size) < 500, TIME, TIME + 0.2)
    file = table(tmp_path, "t,pos,cur", plain_rows(late))
    for rate, step in (("100 Hz", 0.01), ("4 kHz", 0.00025)):
        mapping = PLAIN.replace('unit = "s"', f'unit = "s"\nresample = "{rate}"', 1)
        made = one(tmp_path, file, mapping)
        times = made.recording.time
        assert not ((times > 0.4991) & (times < 0.6999)).any()
        assert np.median(np.diff(times)) == pytest.approx(step)
        there = np.interp(times, late, POSITION)
        assert np.abs(made.recording["position"] - there)[1:-1].max() < 2e-3
    noise = np.random.default_rng(1).standard_normal(TIME.size)
    rows = [[row[0], row[1], f"{x:.9g}"] for row, x in zip(plain_rows(), noise, strict=True)]
    mapping = PLAIN.replace('unit = "s"', 'unit = "s"\nresample = "50 Hz"', 1)
    made = one(tmp_path, table(tmp_path, "t,pos,cur", rows), mapping)
    assert made.recording["current"].std() < 0.35  # a mean of 20: 0.22; picked samples: 1


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('unit = "rad"', 'unit = "V"', 'channels.position.unit = "V" cannot be used'),
        ('unit = "rad"', 'unt = "rad"', 'did you mean "unit"'),
        ("[channels.position]", "[channels.positoin]", 'did you mean "position"'),
        ('column = "pos"', 'column = "poss"', 'did you mean "pos"'),
        ('column = "pos"', "column = 7", "has 3 columns, none with number 7"),
        ('column = "pos"', "column = 0", "number from 1"),
        ('column = "t"\nunit = "s"', 'sampling = "0 Hz"', "time.sampling = 0 Hz"),
        ('column = "t"', 'sampling = "1 kHz"\ncolumn = "t"', "one of the two"),
        ('unit = "rad"', 'unit = "rad"\nside = "motr"', 'did you mean "motor"'),
        ('unit = "rad"', 'unit = "rad"\nscale = "3 mm"', "channels.position.scale"),
        ('unit = "rad"', 'unit = "rad"\noffset = "3 mm"', "channels.position.offset"),
        ('unit = "A"', 'unit = "A"\nside = "motor"', "angles and angular speeds only"),
        ('unit = "A"', 'unit = "A"\nindex = 2', "no number 2"),
        ('unit = "A"', 'unit = "A"\nfill = "linaer"', 'did you mean "linear"'),
        ("[time]", 'experiment = "void-closur"\n[time]', 'did you mean "void-closure"'),
        ("[time]", 'plant = "hnd"\n[time]', 'did you mean "hand"'),
        ("[time]", '[align]\nto = "experiment"\n[time]', "the mapping names no experiment"),
        ("[time]", '[align]\nto = "reference"\n[time]', "no channel reference is mapped"),
        ("[time]", "[time\n", "not valid TOML"),
    ],
)
def test_a_fault_in_a_mapping_is_one_line(tmp_path, capsys, old, new, said):
    assert old in PLAIN
    mapping = saved(tmp_path, PLAIN.replace(old, new, 1))
    line = refused(capsys, tmp_path, table(tmp_path, "t,pos,cur", plain_rows()), mapping)
    assert said in line and ("map.toml" in line or "log.csv" in line)


@pytest.mark.parametrize(
    ("row", "cells", "said"),
    [
        (5, ["0.005", "x", "1"], "log.csv, line 7: 'x' is not a number"),
        (5, ["0.005", "1", "inf"], "log.csv, line 7: the value is not finite"),
        (5, ["0.005", "1"], "log.csv, line 7: expected 3 columns, got 2"),
        (5, ["0.004", "1", "1"], "log.csv, line 7: time does not increase"),
        (5, ["0.005", '"1,5"', "1"], "decimal"),
    ],
)
def test_a_fault_in_a_row_names_its_line(tmp_path, capsys, row, cells, said):
    rows = plain_rows()
    rows[row] = cells
    file = table(tmp_path, "t,pos,cur", rows)
    assert said in refused(capsys, tmp_path, file, saved(tmp_path, PLAIN))


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("log.csv", b"", "empty"),
        ("log.csv", b"t,pos,cur\n1,2,3\n", "two or more lines"),
        ("log.csv", b"\x00\x01\xff\xfe", "text"),
        ("log.h5", b"no such format", "cannot be read as HDF5"),
        ("log.mat", b"no such format", "no MATLAB file"),
        ("nothing.mat", None, "no such file"),
        ("nothing.csv", None, "no such file"),
    ],
)
def test_a_file_that_is_none_is_one_line(tmp_path, capsys, name, content, said):
    if content is not None:
        (tmp_path / name).write_bytes(content)
    assert said in refused(capsys, tmp_path, tmp_path / name, saved(tmp_path, PLAIN))


def refused(capsys, folder, file, mapping):
    out = folder / "out.csv"
    assert main(["convert", str(file), "--mapping", str(mapping), "--out", str(out)]) == 2
    printed = capsys.readouterr()
    (line,) = printed.err.splitlines()
    assert printed.out == "" and not out.exists()
    return line


def test_the_command_reports_the_conversion_and_keeps_it(tmp_path, capsys):
    file = table(tmp_path, "t,pos,cur", plain_rows())
    mapping = saved(tmp_path, 'experiment = "void-closure"\n' + PLAIN)
    for name in ("run.csv", "RUN2.CSV", "run.h5"):
        out = tmp_path / name
        words = ["convert", str(file), "--mapping", str(mapping), "--out", str(out)]
        assert main(words) == 0
        assert "1000 samples from 0 to 0.999 s, every 1 ms" in capsys.readouterr().out
        assert main([*words, "--json"]) == 0
        (row,) = json.loads(capsys.readouterr().out)["recordings"]
        assert row.pop("out") == str(out)
        assert {"level", "kind", "channel", "text"} <= set(row.pop("findings")[0])
        kept = Recording.read(out)
        sidecar = tmp_path / f"{name}{CONVERTED}"
        stored = kept.conversion or sidecar.read_text(encoding="utf-8")
        assert row.items() <= json.loads(stored).items()
        assert sidecar.exists() == (name != "run.h5")
        assert ("duration" in kept.experiment) == (name == "run.h5")


def test_several_files_need_a_folder(tmp_path):
    file = table(tmp_path, "t,pos,cur", plain_rows())
    made = convert([file, file], saved(tmp_path, PLAIN))
    with pytest.raises(BadInput, match="name a folder"):
        write(made, tmp_path / "out.csv")
    with pytest.raises(BadInput, match="two files would become"):
        write(made, tmp_path / "out")


def test_the_mapping_that_the_help_shows_can_be_read(tmp_path):
    shown = EXAMPLES["convert"].partition("left out:\n")[2]
    mapping = read_mapping(saved(tmp_path, textwrap.dedent(shown)))
    assert mapping.align is not None and mapping.split is not None
    assert mapping.channels["position"].factor == pytest.approx(-0.0879 * DEGREE / 19.0)
