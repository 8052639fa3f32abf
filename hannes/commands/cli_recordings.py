"""The commands about recordings at large: convert foreign files, check any before a fit."""

import argparse
import sys
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hannes.commands.cli_findings import faults_listed, faulty_files, finding_counts, finding_lines
from hannes.commands.cli_output import add_force, add_json, print_json
from hannes.commands.cli_trust import add_trust
from hannes.commands.next_step import after_check, after_convert
from hannes.core.errors import printable

if TYPE_CHECKING:
    from hannes.campaigns.quality.finding import Finding

EXAMPLES = {
    "begin": """\
hannes begin logs/*.csv
hannes begin logs/*.mat --out my-hand
hannes begin run.mcap --plant axis --json

It writes my-hand/mapping.toml. What the logs do not say is marked "?" there:
fill it in and run the same command again. Then it writes recordings and
campaign.toml, and says what `hannes check` finds.""",
    "convert": """\
hannes convert log.csv --mapping rig.toml --out void_01.csv
hannes convert logs/*.mat --mapping rig.toml --out recordings
hannes convert log.csv --mapping rig.toml --out void_01.h5 --json

rig.toml; all of it but time and channels may be left out:
  plant = "hand"                  # whose channels these are; or "axis", "module:object"
  experiment = "void-closure"     # what was done: a shipped name, or a .toml
  missing = ["-999", "n/a"]       # stand for no value, as empty cells and NaN do
  split = "trial"                 # a new run wherever this column changes
  # split_at = "restart"          # or where time restarts; "blank" lines, repeated "header"
  [text]                          # delimiter is detected where not given
  delimiter = "semicolon"
  decimal = ","
  comment = "#"
  header = 3                      # line with the names, 0 for none
  first = 5                       # line of the first numbers
  skip = "^(WARN|boot)"           # lines left out, a regular expression
  ragged = true                   # rows of unequal length
  [time]
  column = "t [ms]"               # or sampling = "1 kHz"
  unit = "ms"                     # or format = "iso", "%H:%M:%S.%f" for dates and times
  wrap = 32768                    # ticks after which the clock restarts
  order = "sort"                  # doubled or swapped rows: drop, mean, sort
  from_zero = true
  offset = "0.2 s"                # added to every time
  resample = "1 kHz"              # else times stay as recorded
  repeats = "drop"                # rows that the logger wrote again
  cut = [["0.41 s", "0.52 s"]]    # stretches that are left out
  [channels.position]
  column = "encoder"              # name or number; HDF5, MATLAB: path, with index = 2
  unit = "deg"
  scale = "0.0879"                # degrees per count
  side = "motor"                  # divided by the reducer's ratio
  reversed = true
  offset = "-0.31 rad"            # added at the end
  fill = "hold"                   # a missing value: drop its row, hold, or linear
  signed = 16                     # bits of an integer that was logged as unsigned
  unwrap = 4096                   # raw counts after which a counter restarts
  index = 3                       # place in a list in a cell, or in an array
  [channels.duty]
  column = "pwm"
  unit = "%"
  [channels.current]
  column = "bus current"
  unit = "mA"
  kind = "supply"                 # measured at the supply: divided by the channel duty
  [channels.supply]
  constant = "12 V"               # no column, the same throughout
  [channels.reference]
  from = "command"                # a further file, on a clock of its own
  column = "goal"
  unit = "rad"
  [files.command]
  replace = "_state"              # in the first file's name
  by = "_command"
  time = { column = "t", unit = "s" }
  [align]
  to = "experiment"               # or "reference", where that is another logger's
  by = "simulation"               # or "command", with lag = "60 ms" of the machine itself
  within = "2 s\"""",
    "check": """\
hannes check void_01.csv void_02.h5
hannes check campaign.toml --notes
hannes check axis.csv --plant axis --json
hannes check log.csv --experiment void-closure
hannes check trials.csv.gz --mapping rh56""",
}


def add(command: Callable[..., argparse.ArgumentParser]) -> None:
    """Add the commands; `command(name, call, description)` makes the parser of one."""
    convert = command("convert", _convert, "read foreign files into recordings")
    convert.add_argument(
        "file",
        nargs="+",
        help="text (also .gz), HDF5, MATLAB, JSON, npz, xlsx, Parquet, MCAP, bags",
    )
    convert.add_argument(
        "--mapping",
        required=True,
        metavar="MAP.toml",
        help="says which column is which channel, and in which unit",
    )
    convert.add_argument(
        "--out", required=True, metavar="FILE", help="a .csv or .h5 file, or a folder for several"
    )
    add_trust(convert)
    add_force(convert)
    add_json(convert)

    begin = command("begin", _begin, "from unknown logs to a mapping and a campaign")
    begin.add_argument("file", nargs="+", help="logs of any kind, all of one layout")
    begin.add_argument(
        "--out", default="bench", metavar="FOLDER", help="folder of the results (bench)"
    )
    begin.add_argument(
        "--plant",
        default="hand",
        help="recorded machine: hand (default), axis, finger, module:object",
    )
    add_json(begin)

    check = command("check", _check, "say what may be wrong with recordings, before any fit")
    check.add_argument("file", nargs="+", help="recordings, or a campaign's .toml file")
    check.add_argument(
        "--plant", help="recorded machine: hand (default), axis, finger, module:object"
    )
    check.add_argument(
        "--experiment",
        metavar="NAME",
        help="experiment that was recorded, where the file does not say",
    )
    check.add_argument(
        "--mapping", metavar="MAP.toml", help="mapping through which the files, raw logs, are read"
    )
    check.add_argument("--notes", action="store_true", help="print notes too: noise, resolution")
    add_trust(check)
    add_json(check)


def _convert(chosen: argparse.Namespace) -> None:
    from hannes.campaigns.check import check
    from hannes.campaigns.convert import convert, planned, write
    from hannes.campaigns.foreign.mapping_file import read_mapping
    from hannes.core.io.inputs import noted
    from hannes.core.io.outputs import require_free

    for target in planned(chosen.file, chosen.out):
        require_free("convert", target, [chosen.mapping, *chosen.file], force=chosen.force)
    with noted() as inputs:
        mapping = read_mapping(chosen.mapping)
        made = convert(chosen.file, mapping)
    paths = write(made, chosen.out, reads=inputs, force=chosen.force)
    found = [check(each.recording, mapping.plant) for each in made]
    rows = [{**each.report, "out": str(path)} for each, path in zip(made, paths, strict=True)]
    if chosen.json:
        for row, findings in zip(rows, found, strict=True):
            row["findings"] = [asdict(each) for each in findings]
        print_json({"recordings": rows})
        return
    for row, findings in zip(rows, found, strict=True):
        print("\n".join([_summary_text(row), *finding_lines(findings, notes=False)]))
    print(printable(after_convert(chosen.mapping, [str(path) for path in paths], found)))


def _begin(chosen: argparse.Namespace) -> None:
    from hannes.campaigns.begin.begin import CAMPAIGN, begin, counted

    begun = begin(chosen.file, chosen.out, chosen.plant)
    if chosen.json:
        print_json(
            {
                "out": str(begun.out),
                "seen": begun.seen,
                "missing": begun.missing,
                "conditions": [
                    {"name": each.name, "files": list(map(str, each.files))}
                    for each in begun.conditions
                ],
                "next": begun.next,
            }
        )
        return
    for line in begun.seen:
        print(f"  saw      {printable(line)}")
    for line in begun.missing:
        print(f"  missing  {printable(line)}")
    for each in begun.conditions:
        print(f"  {counted(len(each.files), 'run')}   {printable(each.name)} (by {each.why})")
    if begun.recordings:
        checked = argparse.Namespace(
            file=[str(begun.out / CAMPAIGN)], plant=None, experiment=None, mapping=None,
            notes=False, json=False,
        )  # fmt: skip
        if missing := _missing(checked):
            print(f"  missing  {printable(missing)}")
            campaign = printable(begun.out / CAMPAIGN)
            print(f"next: edit {campaign}, then: hannes check {campaign}")
            return
    print(f"next: {printable(begun.next)}")


def _check(chosen: argparse.Namespace) -> None:
    from hannes.core.errors import BadInput

    found = _checked(chosen)
    faulty = faulty_files(found)
    if not chosen.json:
        print(printable(after_check(chosen.file, faulty)))
    sys.stdout.flush()  # before the line on standard error
    if faulty:
        raise BadInput(faults_listed(faulty, chosen.json))


def _missing(checked: argparse.Namespace) -> str:
    """What keeps a new campaign from being used, or an empty string."""
    from hannes.core.errors import BadInput

    try:
        faulty = faulty_files(_checked(checked))
    except BadInput as error:
        return str(error)
    return faults_listed(faulty) if faulty else ""


def _checked(chosen: argparse.Namespace) -> list[tuple[str, list["Finding"]]]:
    """Check the files, print what was found, and return it by name."""
    from hannes.campaigns.campaign_file import read_campaign
    from hannes.campaigns.check import check, subjects
    from hannes.campaigns.shared_findings import with_shared_as_warnings
    from hannes.campaigns.warnings import across_runs

    found = list[tuple[str, list["Finding"]]]()
    for path in chosen.file:
        given = subjects(path, chosen.plant, chosen.experiment, mapping=chosen.mapping)
        own = [(name, check(recording, plant)) for name, recording, plant in given]
        if Path(path).suffix in (".toml", ""):
            campaign = read_campaign(path)
            own = with_shared_as_warnings(campaign, own)
            own += [(str(path), more)] if (more := across_runs(campaign)) else []
        found += own
    if chosen.json:
        rows = [
            {"file": name, "findings": [asdict(each) for each in findings]}
            for name, findings in found
        ]
        print_json({"recordings": rows})
    else:
        for name, findings in found:
            head = f"{printable(name)}: {finding_counts(findings)}"
            print("\n".join([head, *finding_lines(findings, chosen.notes)]))
    return found


def _summary_text(row: dict[str, Any]) -> str:
    """What was done to make one recording, as lines for a terminal."""
    span, interval = row["span"], row["interval"]
    lines = [
        f"{printable(row['out'])}: {row['samples']} samples "
        f"from {span['t0']:.6g} to {span['t1']:.6g} s, "
        f"every {1e3 * interval['median']:.4g} ms "
        f"({1e3 * interval['shortest']:.4g} to {1e3 * interval['longest']:.4g})"
    ]
    for name, each in row["channels"].items():
        added = f" + {each['offset']:.6g}" if each["offset"] else ""
        lines.append(
            f"  {name} [{each['unit']}] = {each['factor']:.6g} x {each['column']!r}{added}"
        )
    if row["dropped_rows"]:
        lines.append(f"  {row['dropped_rows']} rows left out: a value was missing")
    if row["disordered_rows"]:
        lines.append(f"  {row['disordered_rows']} rows left out: their time was doubled or late")
    for name, count in row["filled_values"].items():
        lines.append(f"  {name}: {count} missing values filled in")
    if shift := row["shift"]:
        lines.append(
            f"  shift {shift['value']:.6g} s ({shift['low']:.6g} to {shift['high']:.6g}): "
            f"{shift['what']}"
        )
    return "\n".join(lines)
