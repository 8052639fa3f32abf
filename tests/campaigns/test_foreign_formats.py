"""Files as labs write them, each read by a mapping alone: the same numbers whatever the format."""

import json

import h5py
import numpy as np
import pytest

from hannes.campaigns.convert import convert
from hannes.campaigns.foreign.mapping_file import read_mapping
from hannes.campaigns.foreign.to_recordings import read_runs
from hannes.commands.cli import main
from hannes.core.errors import BadInput

TIME = np.round(0.01 * np.arange(60), 6)
POSITION = np.round(np.sin(3.0 * TIME), 9)
CURRENT = np.round(0.2 * np.cos(3.0 * TIME), 9)


def mapping(
    folder, time='column = "t"\nunit = "s"', position="pos", current="cur", head="", more=""
):
    text = (
        f'{head}\n[time]\n{time}\n[channels.position]\ncolumn = "{position}"\nunit = "rad"\n'
        f'[channels.current]\ncolumn = "{current}"\nunit = "A"\n{more}\n'
    )
    (folder / "map.toml").write_text(text)
    return folder / "map.toml"


def same(made, position=POSITION, current=CURRENT, time=TIME):
    assert made.recording.time == pytest.approx(time, abs=1e-9)
    assert made.recording["position"] == pytest.approx(position, abs=1e-9)
    assert made.recording["current"] == pytest.approx(current, abs=1e-9)


RECORDS = [
    {"t": t, "motor": {"q": x, "i": i}, "word": "x"}
    for t, x, i in zip(TIME.tolist(), POSITION.tolist(), CURRENT.tolist(), strict=True)
]


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("log.json", json.dumps(RECORDS)),
        ("log.jsonl", "\n".join(map(json.dumps, RECORDS)) + '\n{"t": 0.6, "mot'),
        ("log.json", json.dumps({"t": TIME.tolist(), "motor": {"q": POSITION.tolist(),
                                                             "i": CURRENT.tolist()}})),
    ],
    ids=["records", "lines cut off at the end", "table"],
)  # fmt: skip
def test_json(tmp_path, name, text):
    (tmp_path / name).write_text(text)
    (made,) = convert([tmp_path / name], mapping(tmp_path, position="motor.q", current="motor.i"))
    same(made)


def test_npz_and_structured_npy(tmp_path):
    np.savez(tmp_path / "log.npz", t=TIME, pos=POSITION, cur=CURRENT, words=np.array(["a"], object))
    (made,) = convert([tmp_path / "log.npz"], mapping(tmp_path))
    same(made)
    rows = np.zeros(TIME.size, [("t", float), ("pos", float), ("cur", float)])
    rows["t"], rows["pos"], rows["cur"] = TIME, POSITION, CURRENT
    np.save(tmp_path / "log.npy", rows)
    where = mapping(tmp_path, 'column = "data.t"\nunit = "s"', "data.pos", "data.cur")
    same(convert([tmp_path / "log.npy"], where)[0])


def test_spreadsheet(tmp_path):
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.Workbook()
    sheet = book.active
    sheet.append(["bench 3", None, None])
    sheet.append(["t", "pos", "cur"])
    for row in zip(TIME.tolist(), POSITION.tolist(), CURRENT.tolist(), strict=True):
        sheet.append(row)
    book.save(tmp_path / "log.xlsx")
    same(convert([tmp_path / "log.xlsx"], mapping(tmp_path))[0])


def test_lerobot_data_set(tmp_path):
    arrow, parquet = pytest.importorskip("pyarrow"), pytest.importorskip("pyarrow.parquet")
    root = tmp_path / "pick"
    (root / "meta").mkdir(parents=True)
    (root / "data" / "chunk-000").mkdir(parents=True)
    names = {"observation.state": {"names": ["elbow.pos", "elbow.current"]}}
    (root / "meta" / "info.json").write_text(json.dumps({"features": names}))
    for episode in range(2):
        state = np.stack([POSITION + episode, CURRENT], axis=1).astype(np.float64)
        table = arrow.table(
            {
                "observation.state": arrow.array(state.tolist()),
                "timestamp": TIME,
                "episode_index": np.full(TIME.size, episode),
            }
        )
        parquet.write_table(table, root / "data" / "chunk-000" / f"file-{episode:03d}.parquet")
    where = mapping(
        tmp_path,
        'column = "timestamp"\nunit = "s"',
        "observation.state/elbow.pos",
        "observation.state/elbow.current",
        'split = "episode_index"',
    )
    first, second = convert([root], where)
    same(first)
    same(second, POSITION + 1.0)


def test_mcap_of_json_and_of_ros(tmp_path):
    writer_module = pytest.importorskip("mcap.writer")
    with (tmp_path / "log.mcap").open("wb") as file:
        writer = writer_module.Writer(file)
        writer.start()
        schema = writer.register_schema("State", "jsonschema", b"{}")
        channel = writer.register_channel("/arm/state", "json", schema)
        for record in RECORDS:
            stamp = round(1e9 * (100.0 + record["t"]))
            writer.add_message(channel, stamp, json.dumps(record).encode(), stamp)
        writer.finish()
    where = mapping(
        tmp_path, 'column = "arm/state/time"\nunit = "s"', "arm/state/motor/q", "arm/state/motor/i"
    )
    same(convert([tmp_path / "log.mcap"], where)[0])


def test_a_bag_of_joint_states(tmp_path):
    bags = pytest.importorskip("rosbags.rosbag2")
    typesys = pytest.importorskip("rosbags.typesys")
    store = typesys.get_typestore(typesys.Stores.ROS2_HUMBLE)
    types = store.types
    with bags.Writer(tmp_path / "bag", version=9) as writer:
        connection = writer.add_connection(
            "/joint_states", "sensor_msgs/msg/JointState", typestore=store
        )
        for t, x, i in zip(TIME, POSITION, CURRENT, strict=True):
            nano = round(1e9 * (50.0 + t))
            stamp = types["builtin_interfaces/msg/Time"](sec=nano // 10**9, nanosec=nano % 10**9)
            message = types["sensor_msgs/msg/JointState"](
                header=types["std_msgs/msg/Header"](stamp=stamp, frame_id=""),
                name=["wrist", "elbow"],
                position=np.array([0.0, x]),
                velocity=np.zeros(2),
                effort=np.array([0.0, i]),
            )
            writer.write(connection, nano, store.serialize_cdr(message, connection.msgtype))
    where = mapping(
        tmp_path,
        'column = "joint_states/time"\nunit = "s"',
        "joint_states/position/elbow",
        "joint_states/effort/elbow",
    )
    same(convert([tmp_path / "bag"], where)[0])


def test_matlab_structures_in_arrays_and_references(tmp_path):
    from scipy.io import savemat

    signals = np.zeros((2,), dtype=[("values", object), ("label", object)])
    signals[0] = (POSITION[:, np.newaxis], "q")
    signals[1] = (CURRENT[:, np.newaxis], "i")
    savemat(tmp_path / "scope.mat", {"Scope": {"time": TIME[:, np.newaxis], "signals": signals}})
    where = mapping(
        tmp_path,
        'column = "Scope.time"\nunit = "s"',
        "Scope.signals(1).values",
        "Scope.signals(2).values",
    )
    same(convert([tmp_path / "scope.mat"], where)[0])
    with h5py.File(tmp_path / "cells.mat", "w") as file:
        for name, values in (("a", POSITION), ("b", CURRENT)):
            file[f"#refs#/{name}"] = values[np.newaxis]
        cells = file.create_dataset("trace/Y", (2, 1), dtype=h5py.ref_dtype)
        cells[:, 0] = [file["#refs#/a"].ref, file["#refs#/b"].ref]
        file["trace/t"] = TIME[np.newaxis]
    where = mapping(tmp_path, 'column = "trace.t"\nunit = "s"', "trace.Y{1}", "trace.Y{2}")
    (tmp_path / "v73.mat").write_bytes((tmp_path / "cells.mat").read_bytes())
    where = mapping(tmp_path, 'column = "trace.t"\nunit = "s"', "trace.Y{1}", "trace.Y{2}")
    same(convert([(tmp_path / "cells.mat").rename(tmp_path / "cells.h5")], where)[0])


def rows(columns, header="t,pos,cur"):
    lines = [header, *(",".join(map(str, row)) for row in zip(*columns, strict=True))]
    return "\n".join(lines) + "\n"


def test_signed_wrapped_and_unwrapped_counts(tmp_path):
    ticks = (30_000 + np.arange(TIME.size) * 100) % 32_768
    counts = np.round(POSITION * 1000.0).astype(int) % 700
    milliamperes = np.round(CURRENT * 1000.0).astype(int) % 65_536
    (tmp_path / "log.csv").write_text(rows([ticks, counts, milliamperes]))
    text = (
        '[time]\ncolumn = "t"\nunit = "ms"\nwrap = 32768\nfrom_zero = true\n'
        '[channels.position]\ncolumn = "pos"\nunit = "rad"\nscale = "0.001"\nunwrap = 700\n'
        '[channels.current]\ncolumn = "cur"\nunit = "mA"\nsigned = 16\n'
    )
    (tmp_path / "map.toml").write_text(text)
    (made,) = convert([tmp_path / "log.csv"], tmp_path / "map.toml")
    same(made, np.round(POSITION, 3), np.round(CURRENT, 3), 10.0 * TIME)


@pytest.mark.parametrize("split", ["restart", "blank", "header"])
def test_runs_one_after_another(tmp_path, split):
    block = [f"{t},{x},{i}" for t, x, i in zip(TIME, POSITION, CURRENT, strict=True)]
    between = {"restart": [], "blank": [""], "header": ["t,pos,cur"]}[split]
    lines = ["t,pos,cur", *block, *between, *block, *between, *block]
    (tmp_path / "log.csv").write_text("\n".join(lines) + "\n")
    made = convert([tmp_path / "log.csv"], mapping(tmp_path, head=f'split_at = "{split}"'))
    assert len(made) == 3
    for each in made:
        same(each)


def test_runs_by_labels_in_words_of_which_only_the_first_is_written(tmp_path):
    label = np.where(np.arange(TIME.size) == 0, "pinch", "")
    other = np.where(np.arange(TIME.size) == 0, "power", "")
    text = rows([TIME, POSITION, CURRENT, label], "t,pos,cur,trial")
    text += rows([TIME, POSITION, CURRENT, other]).split("\n", 1)[1]
    (tmp_path / "log.csv").write_text(text)
    first, second = convert([tmp_path / "log.csv"], mapping(tmp_path, head='split = "trial"'))
    same(first)
    same(second)


@pytest.mark.parametrize("order", ["drop", "mean", "sort"])
def test_doubled_and_swapped_rows(tmp_path, order):
    places = np.arange(TIME.size)
    places[[20, 21]] = [21, 20]
    places = np.insert(places, 40, places[40])
    time = TIME[places]
    (tmp_path / "log.csv").write_text(rows([time, POSITION[places], CURRENT[places]]))
    plain = mapping(tmp_path)
    with pytest.raises(BadInput, match=r"time\.order"):
        convert([tmp_path / "log.csv"], plain)
    where = mapping(tmp_path, f'column = "t"\nunit = "s"\norder = "{order}"')
    (made,) = convert([tmp_path / "log.csv"], where)
    kept = np.delete(np.arange(TIME.size), 20) if order == "drop" else np.arange(TIME.size)
    same(made, POSITION[kept], CURRENT[kept], TIME[kept])
    assert made.report["disordered_rows"] == (2 if order == "drop" else 1)


def test_lines_left_out_and_rows_of_unequal_length(tmp_path):
    text = rows([TIME, POSITION, CURRENT]).split("\n")
    text.insert(10, "WARN: voltage low")
    text.insert(30, "[boot] again")
    text[1] += ",a comment"
    (tmp_path / "log.csv").write_text("\n".join(text))
    head = '[text]\nskip = "^(WARN|\\\\[)"\nragged = true'
    same(convert([tmp_path / "log.csv"], mapping(tmp_path, head=head))[0])


def test_clock_times_of_other_customs(tmp_path):
    stamps = [f"26.11.2026 09:12:{t:09.6f}" for t in TIME]
    (tmp_path / "log.csv").write_text(rows([stamps, POSITION, CURRENT]))
    where = mapping(tmp_path, 'column = "t"\nformat = "%d.%m.%Y %H:%M:%S.%f"')
    same(convert([tmp_path / "log.csv"], where)[0])


def test_lists_in_cells_of_two_files_on_two_clocks(tmp_path):
    cells = [f'"[0.0, {x}, {i}]"' for x, i in zip(POSITION, CURRENT, strict=True)]
    (tmp_path / "run_state.csv").write_text(rows([1e6 * TIME, cells], "stamp,values"))
    steps, heights = np.array([0.0, 0.255, 0.4]), [1.0, 2.0, 3.0]
    commands = [f'"[9.0, {x}]"' for x in heights]
    (tmp_path / "run_control.csv").write_text(rows([1e6 * steps, commands], "stamp,values"))
    (tmp_path / "map.toml").write_text(
        '[time]\ncolumn = "stamp"\nunit = "us"\n'
        '[channels.position]\ncolumn = "values"\nindex = 2\nunit = "rad"\n'
        '[channels.current]\ncolumn = "values"\nindex = 3\nunit = "A"\n'
        '[channels.reference]\ncolumn = "values"\nindex = 2\nunit = "rad"\nfrom = "command"\n'
        '[channels.supply]\nconstant = "12 V"\n'
        '[files.command]\nreplace = "_state"\nby = "_control"\n'
        'time = { column = "stamp", unit = "us" }\n'
    )
    (made,) = convert([tmp_path / "run_state.csv"], tmp_path / "map.toml")
    same(made)
    assert made.recording["reference"][[0, 25, 26, 39, 40]] == pytest.approx([1, 1, 2, 2, 3])
    assert set(made.recording["supply"]) == {12.0}


@pytest.mark.parametrize(
    "clock", ['offset = "-3600 s"', "from_zero = true"], ids=["offset", "from zero"]
)
def test_another_files_clock_is_put_on_that_of_the_first(tmp_path, clock):
    (tmp_path / "run_state.csv").write_text(rows([TIME, POSITION, CURRENT], "t,pos,cur"))
    asked = rows([TIME + 3600.0, 2.0 * TIME], "t,asked")
    (tmp_path / "run_command.csv").write_text(asked)
    text = (
        '[time]\ncolumn = "t"\nunit = "s"\n'
        '[channels.position]\ncolumn = "pos"\nunit = "rad"\n'
        '[channels.current]\ncolumn = "cur"\nunit = "A"\n'
        '[channels.reference]\ncolumn = "asked"\nunit = "rad"\nfrom = "command"\n'
        '[files.command]\nreplace = "_state"\nby = "_command"\n'
        '[files.command.time]\ncolumn = "t"\nunit = "s"\n'
    )
    (tmp_path / "map.toml").write_text(text)
    with pytest.raises(BadInput, match=r'never meet; set files.command.time.offset = "-3600 s"'):
        convert([tmp_path / "run_state.csv"], tmp_path / "map.toml")
    (tmp_path / "map.toml").write_text(text + clock + "\n")
    (made,) = convert([tmp_path / "run_state.csv"], tmp_path / "map.toml")
    assert made.recording["reference"] == pytest.approx(2.0 * TIME, abs=0.05)
    (tmp_path / "run_command.csv").write_text(rows([TIME + 1772563392.25, 2.0 * TIME], "t,asked"))
    (tmp_path / "map.toml").write_text(text)
    with pytest.raises(BadInput, match=r'offset = "-1772563392.25 s"'):
        convert([tmp_path / "run_state.csv"], tmp_path / "map.toml")
    (tmp_path / "run_command.csv").write_text("t,asked\n,1.0\n,2.0\n")
    with pytest.raises(BadInput, match="its clock has no known time"):
        convert([tmp_path / "run_state.csv"], tmp_path / "map.toml")


def test_supply_current_becomes_motor_current(tmp_path):
    duty = np.round(0.5 * np.cos(3.0 * TIME), 9)
    (tmp_path / "log.csv").write_text(rows([TIME, POSITION, CURRENT * duty, duty], "t,pos,cur,pwm"))
    more = 'kind = "supply"\n[channels.duty]\ncolumn = "pwm"\nunit = "1"'
    (made,) = convert([tmp_path / "log.csv"], mapping(tmp_path, more=more))
    far = np.abs(duty) > 0.05
    assert made.recording["current"][far] == pytest.approx(CURRENT[far], abs=1e-6)


@pytest.mark.parametrize(
    ("name", "start", "said"),
    [
        ("log.tdms", b"TDSm\x0e\x00", "LabVIEW TDMS"),
        ("log.pkl", b"\x80\x04\x95\x10", "pickle"),
        ("log.xls", b"\xd0\xcf\x11\xe0\xa1", "save it as .xlsx"),
        ("log.zip", b"PK\x03\x04", "unpack it first"),
        ("log.db", b"SQLite format 3\0", "SQLite"),
        ("log.mcap", b"\x89MCAP0\r\n\x00", "cannot be read"),
        ("log.parquet", b"PAR1 and no more", "cannot be read"),
        ("log.npz", b"PK\x03\x04 and no more", "cannot be read"),
        ("log.json", b'[{"t": 1}, {', "is no JSON"),
    ],
)
def test_what_is_not_read_is_named(tmp_path, capsys, name, start, said):
    (tmp_path / name).write_bytes(start)
    out = str(tmp_path / "x.csv")
    asked = ["convert", str(tmp_path / name), "--mapping", str(mapping(tmp_path)), "--out", out]
    assert main(asked) == 2
    assert said in (line := capsys.readouterr().err) and line.count("\n") == 1


STACKED = """split_at = "stacked"
[time]
column = "t"
unit = "s"
[channels.reference]
column = "ref"
unit = "rad"
[channels.position]
column = "pos"
unit = "rad"
"""


@pytest.mark.parametrize("turned", [False, True])
def test_each_row_of_an_array_is_a_run(tmp_path, turned):
    time, moves = 0.01 * np.arange(50), np.outer([1.0, 2.0, 3.0], np.linspace(0.0, 1.0, 50))
    np.savez(tmp_path / "a.npz", t=time, ref=moves[0], pos=moves.T if turned else moves)
    (tmp_path / "m.toml").write_text(STACKED)
    runs = read_runs(tmp_path / "a.npz", read_mapping(tmp_path / "m.toml"))
    assert len(runs) == 3
    for run, move in zip(runs, moves, strict=True):
        assert run.time == pytest.approx(time)
        assert run.channels["position"] == pytest.approx(move)
        assert run.channels["reference"] == pytest.approx(moves[0])


@pytest.mark.parametrize(
    ("position", "words"),
    [(np.ones((50, 50)), "whichever order"), (np.ones((3, 40)), "whichever"),
     (np.ones(50), "two axes")],
)  # fmt: skip
def test_arrays_that_are_no_runs_are_refused(tmp_path, position, words):
    np.savez(tmp_path / "a.npz", t=0.01 * np.arange(50), ref=np.ones(50), pos=position)
    (tmp_path / "m.toml").write_text(STACKED)
    with pytest.raises(BadInput, match=words):
        read_runs(tmp_path / "a.npz", read_mapping(tmp_path / "m.toml"))


LONG = """long = { names = "signal", values = "value" }
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


def long_text(folder, rows):
    lines = ["t,signal,value", *(f"{t:.3f},{name},{x:.9f}" for t, name, x in rows)]
    (folder / "a.csv").write_text("\n".join(lines))
    (folder / "m.toml").write_text(LONG)
    return folder / "a.csv", folder / "m.toml"


@pytest.mark.parametrize("blocks", [False, True])
def test_long_tables_of_text_are_turned_wide(tmp_path, blocks):
    rows = [("pos", POSITION), ("cur", CURRENT)]
    values = [(t, name, x) for name, column in rows for t, x in zip(TIME, column, strict=True)]
    file, how = long_text(tmp_path, values if blocks else sorted(values))
    (made,) = convert([file], how)
    same(made)


def test_long_tables_with_runs_below_one_another_need_a_column_for_them(tmp_path):
    values = [(t, name, 0.1) for _ in range(2) for t in TIME for name in ("pos", "cur")]
    file, how = long_text(tmp_path, values)
    with pytest.raises(BadInput, match="as split"):
        convert([file], how)
    how.write_text('split = "run"\n' + LONG)
    lines = file.read_text().splitlines()
    half = len(values) // 2
    marked = [f"{line},{k >= half:d}" for k, line in enumerate(lines[1:])]
    file.write_text("\n".join([lines[0] + ",run", *marked]))
    assert len(convert([file], how)) == 2


def test_a_signal_that_a_long_table_lacks_is_named(tmp_path):
    file, how = long_text(tmp_path, [(t, "pos", 0.1) for t in TIME])
    with pytest.raises(BadInput, match='no signal "cur"'):
        convert([file], how)
