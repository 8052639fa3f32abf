"""Every table of figures stands on the page of evidence with a command beside it that exists."""

import re
import shlex

import pytest
from pages import PAGES, ROOT, name, tables, text, text_of_makefile

EVIDENCE = ROOT / "docs" / "explanation" / "evidence.md"
_COMMAND = re.compile(r"`((?:python -m|hannes|make) [^`]+)`")
_STUDY = re.compile(r"^`([\w-]+)`")  # of a row, under `python -m benchmarks.NAME` and the like


def commands(part):
    return _COMMAND.findall(part)


def exists(command):
    """Whether what a command names is there; nothing is run."""
    words = shlex.split(command)
    match words:
        case ["make", target]:
            return bool(re.search(rf"^{target}:", text_of_makefile(), re.MULTILINE))
        case ["hannes", verb, *_]:
            return (
                text(ROOT / "docs" / "reference" / "commands.md").count(f"## hannes {verb}\n") == 1
            )
        case ["python", "-m", module, *rest]:
            if module == "pytest":
                return True
            file = ROOT / f"{module.replace('.', '/')}.py"
            if module.endswith("NAME"):
                return True  # its rows name the benchmark
            parts = [each for each in rest if not each.startswith("-") and each.isidentifier()]
            there = file.exists() or file.with_suffix("").is_dir()
            return there and all(
                f'"{part}"' in file.read_text() for part in parts if part.islower()
            )
    return False


@pytest.mark.parametrize("table", tables(EVIDENCE), ids=lambda each: f"line {each[0]}")
def test_every_table_of_evidence_has_its_command(table):
    line, rows, above = table
    header = "|".join(rows[0])
    last = "\n".join(above.rstrip().split("\n\n")[-1:])
    each_row = all(commands("|".join(row)) for row in rows[2:])
    assert commands(header) or commands(last) or each_row, f"line {line}: no command beside it"


def test_the_commands_exist():
    whole = text(EVIDENCE)
    for command in commands(whole):
        assert exists(command), command
    named = re.findall(r"\| `(\w+)`: ", whole.split("## Speed")[1])
    assert named and all((ROOT / "benchmarks" / f"{each}.py").exists() for each in named)


def test_tests_that_are_named_exist():
    found = re.findall(r"pytest -k (\w+)", EVIDENCE.read_text(encoding="utf-8"))
    files = [path.stem for path in (ROOT / "tests").rglob("test_*.py")]
    assert found and all(any(word in each for each in files) for word in found)


def test_the_record_that_the_study_prints_is_there():
    (record,) = re.findall(
        r"benchmarks/records/naming[\w.-]+", EVIDENCE.read_text(encoding="utf-8")
    )
    assert (ROOT / record).is_file()


@pytest.mark.parametrize("page", [p for p in PAGES if p != EVIDENCE], ids=name)
def test_intervals_of_figures_stand_nowhere_else(page):
    """A table with 95 % intervals of figures belongs on the page of evidence."""
    if "reference" in page.parts:
        return
    for line, rows, _ in tables(page):
        cells = "|".join(cell for row in rows[2:] for cell in row)
        assert not re.search(r"\d \(-?[\d.]+ to [\d.]+\)", cells), f"{name(page)}, line {line}"


def test_the_table_of_the_naming_study_is_what_its_command_prints():
    """Row by row: figure, interval, number of cases and bound, to the digits of the page."""
    from benchmarks.naming_study import records, summary

    (record,) = re.findall(r"benchmarks/records/naming[\w.-]+", text(EVIDENCE))
    _, printed = summary.figures(list(records.read(ROOT / record)))
    (rows,) = (rows for _, rows, _ in tables(EVIDENCE) if rows[0][0].strip() == "489 cases")
    for row, shown in zip(printed, rows[2:], strict=True):
        name, figure, cases, _ = (cell.strip() for cell in shown)
        assert name[:20] == row["name"][:20]
        assert cases == str(row.get("cases", ""))
        scale = 100.0 if "%" in figure else 1.0
        numbers = re.findall(r"-?\d+(?:\.\d+)?", figure)
        known = [row[key] for key in ("value", "low", "high") if key in row]
        assert len(numbers) == len(known), name
        for number, value in zip(numbers, known, strict=True):
            digits = len(number.partition(".")[2])
            assert abs(float(number) - scale * value) <= 0.51 * 10.0**-digits, name


def test_the_table_of_few_runs_is_what_its_command_prints():
    from benchmarks import study
    from benchmarks.few.summary import figures

    (record,) = set(re.findall(r"benchmarks/records/few[\w.-]+", text(EVIDENCE)))
    _, printed = figures(list(study.read(ROOT / record)))
    (rows,) = (r for _, r, _ in tables(EVIDENCE) if r[0][0].strip().startswith("400 calibrations"))
    for row, (_, figure, _) in zip(printed, rows[2:], strict=True):
        number = re.findall(r"\d+(?:\.\d+)?", figure)[0]
        digits = len(number.partition(".")[2])
        assert f"{100.0 * row['value']:.{digits}f}" == number, row["name"]


def test_the_table_of_guards_is_what_its_command_prints():
    from benchmarks import study
    from benchmarks.guards import figures

    (record,) = set(re.findall(r"benchmarks/records/guards[\w.-]+", text(EVIDENCE)))
    kinds, bounds = figures(list(study.read(ROOT / record)))
    large, sound = ([r for r in kinds if r["campaigns"].startswith(n)] for n in ("large", "sound"))

    def total(some, key):
        return sum(row[key] for row in some)

    missed = total(large, "cases") - total(large, "called_missing")
    (rows,) = (r for _, r, _ in tables(EVIDENCE) if r[0][0].strip().startswith("30 diagnoses"))
    assert [list(map(int, re.findall(r"\d+", row[1]))) for row in rows[2:]] == [
        [bounds[0]["value"]],
        [bounds[1]["value"]],
        [total(large, "right_name")],
        [total(large, "class_with_it"), total(large, "wrong_name")],
        [total(large, "unknown"), missed],
        [total(sound, "wrong_name"), total(sound, "unknown")],
    ]
