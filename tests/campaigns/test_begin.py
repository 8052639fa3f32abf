"""From unknown logs to a campaign: what is seen, what is asked for, and what comes out."""

import numpy as np
import pytest

from hannes.campaigns.begin.begin import CAMPAIGN, MAPPING, begin
from hannes.campaigns.begin.column_guess import split_name
from hannes.campaigns.begin.stamp_form import form_of_stamps
from hannes.campaigns.begin.text_layout import text_layout
from hannes.campaigns.campaign_file import read_campaign
from hannes.campaigns.convert import convert
from hannes.commands.cli import main
from hannes.core.errors import BadInput
from hannes.core.recording.recording import Recording

TIME = np.round(0.005 * np.arange(200), 6)
COMMAND = np.minimum(8.0 * TIME, 5.0)
POSITION = np.round(np.interp(TIME - 0.03, TIME, COMMAND, left=0.0), 6)
CURRENT = np.round(0.3 + 0.02 * np.sin(40.0 * TIME), 6)


def log(folder, name, columns, header, join=",", decimal=".", before=(), end="\n"):
    rows = [
        join.join(f"{x:.6f}".replace(".", decimal) for x in row)
        for row in zip(*columns, strict=True)
    ]
    text = end.join([*before, *([header] if header else []), *rows]) + end
    (folder / name).write_text(text, encoding="utf-8")
    return folder / name


FOUR = (TIME, COMMAND, POSITION, CURRENT)


@pytest.mark.parametrize(
    ("header", "join", "decimal", "before"),
    [
        ("time_s,reference_rad,position_rad,current_A", ",", ".", ()),
        ("Time [s];Goal (rad);Encoder (rad);Motor Current [A]", ";", ",", ()),
        ("t\tsetpoint [rad]\tangle [rad]\tcurrent [A]", "\t", ".", ("rig 3", "")),
        ("# t (s) ref (rad) pos (rad) i (A)".replace(" (", "("), " ", ".", ("# by hand",)),
        (
            "Timestamp (s),Cmd Position (rad),Present Position (rad),Present Current (A)",
            ",",
            ".",
            (),
        ),
    ],
)
def test_logs_that_say_all_become_a_campaign(tmp_path, header, join, decimal, before):
    files = [log(tmp_path, f"void_{k}.csv", FOUR, header, join, decimal, before) for k in (1, 2, 3)]
    begun = begin(files, tmp_path / "bench")
    assert begun.missing == []
    assert [len(each.files) for each in begun.conditions] == [3]
    campaign = read_campaign(tmp_path / "bench" / CAMPAIGN)
    recording = campaign.entries[0].recording
    assert recording.time == pytest.approx(TIME, abs=1e-9)
    for name, values in (("reference", COMMAND), ("position", POSITION), ("current", CURRENT)):
        assert recording[name] == pytest.approx(values, abs=1e-5), name


def test_units_below_the_names(tmp_path):
    lines = ["t,ref,pos,cur", "ms,deg,deg,mA"]
    lines += [
        f"{1e3 * t:.3f},{np.degrees(r):.6f},{np.degrees(p):.6f},{1e3 * i:.4f}"
        for t, r, p, i in zip(*FOUR, strict=True)
    ]
    (tmp_path / "a.csv").write_text("\n".join(lines))
    begun = begin([tmp_path / "a.csv"], tmp_path / "bench")
    assert begun.missing == []
    (made,) = convert([tmp_path / "a.csv"], tmp_path / "bench" / MAPPING)
    assert made.recording["position"] == pytest.approx(POSITION, abs=1e-5)
    assert made.recording.time == pytest.approx(TIME, abs=1e-6)


def test_runs_of_one_file_by_the_command_they_repeat(tmp_path):
    slow = np.minimum(3.0 * TIME, 2.0)
    moved = np.interp(TIME - 0.03, TIME, slow, left=0.0)
    runs = [FOUR, (TIME, slow, moved, CURRENT), FOUR]
    joined = [np.concatenate(each) for each in zip(*runs, strict=True)]
    header = "time_s,reference_rad,position_rad,current_A"
    begun = begin([log(tmp_path, "all.csv", joined, header)], tmp_path / "bench")
    assert [len(each.files) for each in begun.conditions] == [2, 1]


def test_what_is_not_said_is_asked_for_by_name(tmp_path, capsys):
    columns = (TIME, 1000.0 * COMMAND, 1000.0 * POSITION, CURRENT)
    file = log(tmp_path, "a.csv", columns, "t,goal,pos_counts,cur")
    out = tmp_path / "bench"
    assert main(["begin", str(file), "--out", str(out)]) == 0
    said = capsys.readouterr().out
    for word in ("unit of reference", "one count of position", "unit of current", "fill in"):
        assert word in said
    text = (out / MAPPING).read_text()
    with pytest.raises(BadInput, match="unit"):
        convert([file], out / MAPPING)
    text = text.replace('column = "goal"', 'scale = "0.001"\ncolumn = "goal"')
    text = text.replace('scale = "?"', 'scale = "0.001"')
    head, current = text.split("[channels.current]")
    (out / MAPPING).write_text(
        head.replace('unit = "?"', 'unit = "rad"')
        + "[channels.current]"
        + current.replace("?", "A")
    )
    assert main(["begin", str(file), "--out", str(out)]) == 0
    assert "hannes diagnose" in capsys.readouterr().out
    assert read_campaign(out / CAMPAIGN).entries


def test_signs_and_wraps_that_numbers_show(tmp_path):
    counts = np.round(POSITION * 900.0 + 3000.0) % 4096
    milliamperes = np.round((CURRENT - 0.3) * 1000.0).astype(int) % 65536
    file = log(tmp_path, "a.csv", (TIME, counts, milliamperes), "t,position_cnt,current_mA")
    begin([file], tmp_path / "bench")
    text = (tmp_path / "bench" / MAPPING).read_text()
    assert "unwrap = 4096" in text and "signed = 16" in text


def test_an_edited_mapping_is_never_written_over(tmp_path):
    file = log(tmp_path, "a.csv", FOUR, "t,goal,pos,cur")
    begin([file], tmp_path / "bench")
    (tmp_path / "bench" / MAPPING).write_text(
        "# mine\n" + (tmp_path / "bench" / MAPPING).read_text()
    )
    begin([file], tmp_path / "bench")
    assert (tmp_path / "bench" / MAPPING).read_text().startswith("# mine\n")


def test_files_of_another_layout_are_refused(tmp_path):
    one = log(tmp_path, "a.csv", FOUR, "time_s,reference_rad,position_rad,current_A")
    other = log(tmp_path, "b.csv", FOUR, "t,a,b,c")
    with pytest.raises(BadInput, match="other columns"):
        begin([one, other], tmp_path / "bench")


@pytest.mark.parametrize(
    ("name", "words", "unit"),
    [
        ("Motor Current [mA]", ["motor", "current"], "mA"),
        ("pos_rad", ["pos"], "rad"),
        ("CURRENT_MA", ["current"], "mA"),
        ("Realtime Tick(ms)", ["realtime", "tick"], "ms"),
        ("encoderCounts", ["encoder"], "counts"),
        ("t", ["t"], ""),
    ],
)
def test_words_and_unit_of_a_name(name, words, unit):
    assert split_name(name) == (words, unit)


def test_no_numbers_is_one_line(tmp_path):
    (tmp_path / "a.csv").write_text("hello\nworld\n")
    with pytest.raises(BadInput, match="lines of numbers"):
        text_layout(tmp_path / "a.csv")


@pytest.mark.parametrize(
    "header",
    [
        "Zeit [s],Führungsgröße [rad],Drehwinkel [rad],Motorstrom [A]",
        "t [s],Sollwinkel [rad],Istwinkel [rad],Iststrom [A]",
        "Tempo (s),Riferimento (rad),Posizione (rad),Corrente (A)",
        "Temps (s),Consigne (rad),Angle mesuré (rad),Intensité (A)",
        "Tiempo (s),Referencia (rad),Posición (rad),Corriente (A)",
        "Zeit_s,Lage_Sollwert_rad,Lage_Istwert_rad,Strom_Istwert_A",
    ],
)
def test_names_of_other_languages(tmp_path, header):
    begun = begin([log(tmp_path, "a.csv", FOUR, header)], tmp_path / "bench")
    assert begun.missing == []
    (recording,) = (each.recording for each in read_campaign(tmp_path / "bench" / CAMPAIGN).entries)
    for name, values in (("reference", COMMAND), ("position", POSITION), ("current", CURRENT)):
        assert recording[name] == pytest.approx(values, abs=1e-5), name


def test_columns_that_no_channel_takes_are_named(tmp_path):
    header = "time_s,reference_rad,position_rad,current_A,goal_current_A,speed_rad_s,Motor temp"
    file = log(tmp_path, "a.csv", (*FOUR, 2.0 * CURRENT, POSITION, CURRENT), header)
    begun = begin([file], tmp_path / "bench")
    assert begun.missing == []
    assert "not used: goal_current_A, speed_rad_s, Motor temp" in begun.seen
    assert "# not used: goal_current_A" in (tmp_path / "bench" / MAPPING).read_text()
    (made,) = convert([file], tmp_path / "bench" / MAPPING)
    assert made.recording["current"] == pytest.approx(CURRENT, abs=1e-5)


def test_of_two_clocks_the_even_one_and_it_is_said(tmp_path):
    arrival = TIME + 0.002 * np.random.default_rng(1).random(TIME.size)
    header = "time_s,stamp_s,reference_rad,position_rad,current_A"
    file = log(tmp_path, "a.csv", (arrival, *FOUR), header)
    begun = begin([file], tmp_path / "bench")
    assert begun.missing == []
    assert any("stamp_s" in said and 'not from "time_s"' in said for said in begun.seen)
    (made,) = convert([file], tmp_path / "bench" / MAPPING)
    assert made.recording.time == pytest.approx(TIME, abs=1e-6)


def test_two_clocks_that_disagree_are_asked_for(tmp_path):
    header = "time_s,stamp_s,reference_rad,position_rad,current_A"
    file = log(tmp_path, "a.csv", (1.1 * TIME, *FOUR), header)
    begun = begin([file], tmp_path / "bench")
    assert any("disagree" in asked for asked in begun.missing)


def test_a_coarse_clock_is_asked_for(tmp_path):
    header = "time_s,reference_rad,position_rad,current_A"
    file = log(tmp_path, "a.csv", (np.floor(20.0 * TIME) / 20.0, *FOUR[1:]), header)
    begun = begin([file], tmp_path / "bench")
    assert any("share a stamp" in asked for asked in begun.missing)


def test_channels_with_differing_clocks_of_their_own_are_refused(tmp_path):
    lines = ["Name\tReference\tName\tPosition", "Unit\trad\tUnit\trad"]
    lines += [f"{5 * k}\t{0.1 * k}\t{5 * k + 1}\t{0.1 * k}" for k in range(30)]
    (tmp_path / "a.csv").write_text("\n".join(lines))
    with pytest.raises(BadInput, match="clock of its own"):
        begin([tmp_path / "a.csv"], tmp_path / "bench")


def test_arrays_whose_axes_nobody_can_see_are_named(tmp_path):
    np.savez(tmp_path / "a.npz", time_s=TIME, reference_rad=COMMAND, current_limit_A=3.0,
             position_rad=np.stack([POSITION] * 3, axis=1), current_A=CURRENT)  # fmt: skip
    begun = begin([tmp_path / "a.npz"], tmp_path / "bench")
    assert any("not used: position_rad (200, 3)" in said for said in begun.seen)
    assert any('"current_A" [A]' in said for said in begun.seen)


def test_names_with_more_cells_than_the_rows(tmp_path):
    file = log(tmp_path, "a.csv", FOUR, "time_s,reference_rad,position_rad,current_A,Comment")
    assert begin([file], tmp_path / "bench").missing == []


def test_a_long_table_whose_signals_have_their_own_times(tmp_path):
    rows = [(t, "position", x, "rad") for t, x in zip(TIME, POSITION, strict=True)]
    rows += [(t, "current", x, "A") for t, x in zip(TIME[::2], CURRENT[::2], strict=True)]
    rows += [(t, "reference", x, "rad") for t, x in zip(TIME[::4], COMMAND[::4], strict=True)]
    lines = ["time_s,signal,value,unit", *(f"{t},{name},{x},{u}" for t, name, x, u in sorted(rows))]
    (tmp_path / "a.csv").write_text("\n".join(lines))
    begun = begin([tmp_path / "a.csv"], tmp_path / "bench")
    assert begun.missing == []
    assert 'current is not there at every time: fill = "linear"' in begun.seen
    (made,) = convert([tmp_path / "a.csv"], tmp_path / "bench" / MAPPING)
    assert made.recording["position"] == pytest.approx(POSITION[:-1], abs=1e-6)


SERIAL = (("t_ms", 1e3), ("ref_rad", 1.0), ("pos_rad", 1.0), ("I_mA", 1e3))


def serial(folder, between, stamped=True, named=True):
    """Lines of a serial monitor; the machine starts anew among them."""
    lines = []
    for k, row in enumerate(zip(*FOUR, strict=True)):
        cells = [f"{f * x:.3f}" for (_, f), x in zip(SERIAL, row, strict=True)]
        if named:
            cells = [f"{n}:{cell}" for (n, _), cell in zip(SERIAL, cells, strict=True)]
        lines.append((f"16:07:{41 + row[0]:06.3f} -> " if stamped else "") + between.join(cells))
        if k == 100:
            lines.append("16:07:41.500 -> WARN bus: retry" if stamped else "WARN bus: retry")
    if not named:
        lines.insert(0, "16:07:40.900 -> " + between.join(name for name, _ in SERIAL))
    (folder / "serial.txt").write_text("\n".join(["boot v1.2", *lines]))
    return folder / "serial.txt"


@pytest.mark.parametrize(
    ("between", "stamped", "named"),
    [(",", True, True), ("\t", False, True), (" ", True, True), (",", True, False),
     (";", True, False)],
)  # fmt: skip
def test_lines_of_a_serial_monitor(tmp_path, between, stamped, named):
    file = serial(tmp_path, between, stamped, named)
    assert begin([file], tmp_path / "bench").missing == []
    (made,) = convert([file], tmp_path / "bench" / MAPPING)
    assert made.recording.time == pytest.approx(TIME, abs=1e-6)
    assert made.recording["position"] == pytest.approx(POSITION, abs=1e-3)
    assert made.recording["current"] == pytest.approx(CURRENT, abs=1e-5)


def test_stamps_alone_are_the_clock(tmp_path):
    lines = [
        f"16:07:{41 + t:06.3f} -> ref_rad:{r},pos_rad:{p},I_mA:{1e3 * i:.3f}"
        for t, r, p, i in zip(*FOUR, strict=True)
    ]
    (tmp_path / "serial.txt").write_text("\n".join(lines))
    assert begin([tmp_path / "serial.txt"], tmp_path / "bench").missing == []
    (made,) = convert([tmp_path / "serial.txt"], tmp_path / "bench" / MAPPING)
    assert made.recording.time == pytest.approx(TIME, abs=1e-6)


@pytest.mark.parametrize(
    ("cells", "form"),
    [
        (["2026-03-03T18:43:13.25"], "iso"),
        (["03.04.2026 18:43:13,5".replace(",", ".")], "%d.%m.%Y %H:%M:%S.%f"),
        (["3/14/2026 18:43:13"], "%m/%d/%Y %H:%M:%S"),
        (["3/4/2026 18:43:13"], ""),
    ],
)
def test_form_of_stamps(cells, form):
    assert form_of_stamps(cells) == form


@pytest.mark.parametrize("header", ["t_ms,ref_rad,pos_rad,current_mA", "t_ms,ref_rad,pos_rad,IqmA"])
def test_milliamperes_are_no_amperes(tmp_path, header):
    columns = (1e3 * TIME, COMMAND, POSITION, 1e3 * CURRENT)
    file = log(tmp_path, "a.csv", columns, header)
    assert begin([file], tmp_path / "bench").missing == []
    (made,) = convert([file], tmp_path / "bench" / MAPPING)
    assert made.recording["current"] == pytest.approx(CURRENT, abs=1e-5)


def test_json_lines_with_dates_and_times(tmp_path):
    lines = [
        f'{{"time": "2026-03-03T18:43:{10 + t:09.6f}Z", "cmd": {{"angle_rad": {r}}}, '
        f'"state": {{"angle_rad": {p}, "current_mA": {1e3 * i:.3f}, "mode": "run"}}}}'
        for t, r, p, i in zip(*FOUR, strict=True)
    ]
    (tmp_path / "a.jsonl").write_text("\n".join(lines))
    begun = begin([tmp_path / "a.jsonl"], tmp_path / "bench")
    assert begun.missing == []
    (made,) = convert([tmp_path / "a.jsonl"], tmp_path / "bench" / MAPPING)
    assert made.recording.time == pytest.approx(TIME, abs=1e-6)
    for name, values in (("reference", COMMAND), ("position", POSITION), ("current", CURRENT)):
        assert made.recording[name] == pytest.approx(values, abs=1e-5), name


def test_a_name_too_many_is_refused_as_all_columns_may_be_shifted(tmp_path):
    file = log(tmp_path, "a.csv", FOUR, "time_s,mode,reference_rad,position_rad,current_A")
    with pytest.raises(BadInput, match="expected 5 columns"):
        begin([file], tmp_path / "bench")


def test_stamps_of_seconds_and_nanoseconds(tmp_path):
    times = 2.5 * TIME + 0.4
    lines = [
        f'{{"stamp": {{"sec": {int(t)}, "nanosec": {round(1e9 * (t % 1.0))}}}, '
        f'"reference_rad": {r}, "position_rad": {p}, "current_A": {i}}}'
        for t, (_, r, p, i) in zip(times, zip(*FOUR, strict=True), strict=True)
    ]
    (tmp_path / "a.jsonl").write_text("\n".join(lines))
    begun = begin([tmp_path / "a.jsonl"], tmp_path / "bench")
    assert begun.missing == []
    (made,) = convert([tmp_path / "a.jsonl"], tmp_path / "bench" / MAPPING)
    assert made.recording.time == pytest.approx(2.5 * TIME, abs=1e-6)


def test_units_of_an_exported_matlab_file_are_taken_from_it(tmp_path):
    channels = {"time": TIME, "reference": COMMAND, "position": POSITION, "current": CURRENT}
    units = {"time": "s", "reference": "rad", "position": "rad", "current": "A"}
    Recording(channels, units).to_mat(tmp_path / "r.mat")
    begun = begin([tmp_path / "r.mat"], tmp_path / "bench")
    assert begun.missing == []
    made = Recording.read(begun.recordings[0])
    assert np.array_equal(made["current"], CURRENT) and dict(made.units) == units


def test_a_log_without_a_command_ends_with_what_is_missing(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    rows = "".join(f"{k},{5 * (k % 7)},{0.4 * k}\n" for k in range(600))
    (tmp_path / "log.csv").write_text("t [ms],i [mA],angle [deg]\n" + rows, encoding="utf-8")
    assert main(["begin", "log.csv"]) == 0
    said = capsys.readouterr().out
    assert "missing" in said and "neither a channel reference_rad nor an experiment" in said
    assert said.rstrip().splitlines()[-1].startswith("next: edit ")
