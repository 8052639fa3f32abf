"""Several runs in one file, side by side: separated, or asked for; none is lost."""

import json

import h5py
import numpy as np
import pytest

from hannes.campaigns.begin.begin import MAPPING, begin
from hannes.campaigns.convert import convert
from hannes.campaigns.foreign.json_columns import open_json
from hannes.campaigns.foreign.side_by_side import in_order
from hannes.core.errors import BadInput
from hannes.core.recording.recording import Recording

TIME = np.round(0.005 * np.arange(100), 6)
NAMES = ("t_s", "ref_rad", "pos_rad", "cur_A")


def run(number):
    """Columns of one run, which differ from run to run by the current."""
    command = np.minimum(8.0 * TIME, 5.0)
    position = np.interp(TIME - 0.03, TIME, command, left=0.0)
    current = 0.3 + 0.02 * np.sin(40.0 * TIME) + 0.01 * number
    return dict(zip(NAMES, (TIME, command, position, current), strict=True))


RUNS = [run(number) for number in (1, 2, 3)]
LISTS = [{name: each.tolist() for name, each in one.items()} for one in RUNS]


def _struct(one):
    return {"t_s": one["t_s"][:, None], "sig": {n: one[n][:, None] for n in NAMES[1:]}}


def _mat(path, **content):
    from scipy.io import savemat

    savemat(path, content)


def _cell(path):
    cell = np.empty((1, 3), object)
    cell[0] = [_struct(each) for each in RUNS]
    _mat(path, runs=cell)


def _structs(path):
    array = np.zeros((3,), [(name, object) for name in NAMES])
    for number, one in enumerate(RUNS):
        array[number] = tuple(one[name][:, None] for name in NAMES)
    _mat(path, data=array)


def _variables(path):
    _mat(path, **{f"{n}_{k}": one[n] for k, one in enumerate(RUNS, 1) for n in NAMES})


def _referenced(path):
    with h5py.File(path, "w") as file:
        cells = file.create_dataset("runs", (3, 1), dtype=h5py.ref_dtype)
        for number, one in enumerate(RUNS):
            group = file.create_group(f"#refs#/{number}")
            for name in NAMES:
                group[name if name == "t_s" else f"sig/{name}"] = one[name][None]
            cells[number, 0] = group.ref


def _array_of_references(path):
    with h5py.File(path, "w") as file:
        for name in NAMES:
            cells = file.create_dataset(f"data/{name}", (3, 1), dtype=h5py.ref_dtype)
            for number, one in enumerate(RUNS):
                file[f"#refs#/{name}{number}"] = one[name][None]
                cells[number, 0] = file[f"#refs#/{name}{number}"].ref


def _groups(path):
    with h5py.File(path, "w") as file:
        for number, one in enumerate(RUNS, start=9):  # by number, not by letters
            for name in NAMES:
                file[f"trial_{number}/sensors/{name}"] = one[name]


def _sheets(path):
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.Workbook()
    book.remove(book.active)
    for number, one in enumerate(RUNS, start=1):
        sheet = book.create_sheet(f"Versuch {number}")
        sheet.append(["t [s]", "ref [rad]", "pos [rad]", "cur [A]"])
        for row in zip(*one.values(), strict=True):
            sheet.append([float(each) for each in row])
    book.save(path)


def _records(one):
    return [dict(zip(one, row, strict=True)) for row in zip(*one.values(), strict=True)]


WRITERS = {
    "cell.mat": _cell,
    "structs.mat": _structs,
    "variables.mat": _variables,
    "cell73.h5": _referenced,
    "structs73.h5": _array_of_references,
    "groups.h5": _groups,
    "sheets.xlsx": _sheets,
    "named.npz": lambda p: np.savez(
        p, **{f"run{k}_{n}": one[n] for k, one in enumerate(RUNS, 1) for n in NAMES}
    ),
    "list.json": lambda p: p.write_text(json.dumps({"rig": "x", "runs": LISTS})),
    "whole.json": lambda p: p.write_text(json.dumps(LISTS)),
    "named.json": lambda p: p.write_text(
        json.dumps({f"run{k}": one for k, one in enumerate(LISTS, 1)})
    ),
    "records.json": lambda p: p.write_text(json.dumps({"runs": [_records(x) for x in LISTS]})),
    "lines.jsonl": lambda p: p.write_text("\n".join(map(json.dumps, LISTS))),
}


@pytest.mark.parametrize("name", WRITERS)
def test_every_run_of_a_container_is_one(tmp_path, name):
    WRITERS[name](tmp_path / name)
    begun = begin([tmp_path / name], tmp_path / "bench")
    assert begun.missing == []
    assert [len(each.files) for each in begun.conditions] == [3]
    for path, one in zip(begun.recordings, RUNS, strict=True):
        made = Recording.read(path)
        assert made.time == pytest.approx(TIME, abs=1e-9)
        assert made["current"] == pytest.approx(one["cur_A"], abs=1e-9)
        assert made["position"] == pytest.approx(one["pos_rad"], abs=1e-9)


def test_runs_within_runs_though_their_numbers_differ(tmp_path):
    with h5py.File(tmp_path / "a.h5", "w") as file:
        for subject, count in (("subject1", 2), ("subject2", 3)):
            for trial in range(count):
                for name in NAMES:
                    file[f"{subject}/trial_{trial}/{name}"] = RUNS[trial][name]
    begun = begin([tmp_path / "a.h5"], tmp_path / "bench")
    assert len(begun.recordings) == 5


def test_an_array_that_counts_runs(tmp_path):
    joined = {name: np.concatenate([one[name] for one in RUNS]) for name in NAMES}
    joined["t_s"] = 0.005 * np.arange(300)
    np.savez(tmp_path / "a.npz", trial=np.repeat([1, 2, 3], 100), **joined)
    assert len(begin([tmp_path / "a.npz"], tmp_path / "bench").recordings) == 3


@pytest.mark.parametrize("again", [False, True])
def test_what_may_be_conditions_or_machines_is_asked_for(tmp_path, again):
    _mat(tmp_path / "a.mat", data={n: _struct(x) for n, x in zip("xyz", RUNS, strict=True)})
    begun = begin([tmp_path / "a.mat"], tmp_path / "bench")
    if again:  # nothing was filled in: nothing may be taken
        begun = begin([tmp_path / "a.mat"], tmp_path / "bench")
    assert begun.missing
    assert begun.recordings == []


def test_parts_of_one_machine_are_no_runs(tmp_path):
    epoch = {**RUNS[0], "t_s": 1.7e9 + TIME}
    columns = {f"drive{k}/{name}": epoch[name] for k in (1, 2) for name in NAMES}
    np.savez(tmp_path / "a.npz", **columns)
    begun = begin([tmp_path / "a.npz"], tmp_path / "bench")
    assert any("runs of one machine" in each for each in begun.missing)


@pytest.mark.parametrize("name", ["j{}/{}", "m{}/{}", "hand{}/{}", "j{}_{}", "joints/{}/{}"])
def test_counting_alone_makes_no_runs(tmp_path, name):
    np.savez(tmp_path / "a.npz", **{name.format(k, n): RUNS[k][n] for k in (1, 2) for n in NAMES})
    begun = begin([tmp_path / "a.npz"], tmp_path / "bench")
    assert not any("a run for each" in each for each in begun.seen)
    assert any("runs of one machine" in each for each in begun.missing)


def test_superscripts_are_no_numbers_of_runs(tmp_path):
    columns = {f"{k}/{n}": one[n] for k, one in zip("¹²", RUNS, strict=False) for n in NAMES}
    np.savez(tmp_path / "a.npz", **columns)
    assert begin([tmp_path / "a.npz"], tmp_path / "bench").missing  # asked, with no traceback
    assert in_order(("²",)) == [(-1, "²")]


def test_a_field_that_one_run_lacks(tmp_path):
    cell = np.empty((1, 3), object)
    cell[0] = [{n: x for n, x in one.items() if n != "cur_A" or k} for k, one in enumerate(RUNS)]
    _mat(tmp_path / "a.mat", data=cell)
    begun = begin([tmp_path / "a.mat"], tmp_path / "bench")
    assert any("data/2/cur_A" in each and "not every run" in each for each in begun.seen)
    text = (tmp_path / "bench" / MAPPING).read_text()
    text += '[channels.current]\ncolumn = "data/*/cur_A"\nunit = "A"\n'
    (tmp_path / "map.toml").write_text(text)
    with pytest.raises(BadInput, match='holds no "data/1/cur_A"'):
        convert([tmp_path / "a.mat"], tmp_path / "map.toml")


def test_counters_of_runs_are_put_right_each_by_itself(tmp_path):
    turns = np.mod(np.linspace(0.0, 9000.0, 100), 4096.0)
    np.savez(tmp_path / "a.npz", run1=turns, run2=turns, t=TIME)
    (tmp_path / "map.toml").write_text(
        '[time]\ncolumn = "t"\nunit = "s"\n'
        '[channels.position]\ncolumn = "run*"\nunit = "rad"\nscale = 1e-3\nunwrap = 4096\n'
    )
    made = convert([tmp_path / "a.npz"], tmp_path / "map.toml")
    assert [each.recording["position"][0] for each in made] == [0.0, 0.0]
    assert [each.recording["position"][-1] for each in made] == pytest.approx([9.0, 9.0])


def test_json_nested_too_deep_is_refused_in_one_line(tmp_path):
    (tmp_path / "a.json").write_text("[" + '{"a":' * 900 + "1" + "}" * 900 + "]")
    with pytest.raises(BadInput, match="no numbers in it"):
        open_json(tmp_path / "a.json", ())


def test_records_with_lists_stay_records(tmp_path):
    rows = [{"t_s": t, "pos": [0.1, 0.2], "cur": [0.3, 0.4]} for t in TIME]
    (tmp_path / "a.json").write_text(json.dumps(rows))
    begun = begin([tmp_path / "a.json"], tmp_path / "bench")
    assert any('time in "t_s"' in each for each in begun.seen)


@pytest.mark.parametrize(
    ("name", "duty", "supply"),
    [
        ("supply current (A)", True, True),
        ("bus current [A]", True, True),
        ("I_bus (A)", True, True),
        ("Ibat [A]", True, True),
        ("Batteriestrom (A)", True, True),
        ("motor current (A)", True, False),
        ("current_dc (A)", True, None),
        ("input current (A)", True, None),
        ("bus current [A]", False, False),
    ],
)
def test_a_current_of_the_supply_by_its_name(tmp_path, name, duty, supply):
    header = f"t (s),pos (rad),{name}" + (",duty (1)" if duty else "")
    pwm = 0.2 + TIME
    rows = [
        f"{t:.4f},{p:.5f},{0.5 * d:.5f}" + (f",{d:.4f}" if duty else "")
        for t, p, d in zip(TIME, RUNS[0]["pos_rad"], pwm, strict=True)
    ]
    (tmp_path / "a.csv").write_text("\n".join([header, *rows]))
    begun = begin([tmp_path / "a.csv"], tmp_path / "bench")
    assert ('kind = "supply"' in (tmp_path / "bench" / MAPPING).read_text()) == bool(supply)
    assert bool(begun.missing) != (duty and supply is not None)
    if supply:
        assert Recording.read(begun.recordings[0])["current"] == pytest.approx(0.5, abs=1e-3)
