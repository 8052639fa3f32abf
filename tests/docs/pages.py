"""Pages of the documentation for tests: their code blocks run in order, their prose, their links.

A block of `sh` has commands, one of `python` statements in one namespace a page. A block that
begins with a comment that is a file's name, such as `# campaign.toml`, is written to that file.
A block of `text` is output.
"""

import re
import runpy
import shlex
import subprocess
import sys
import tomllib
from dataclasses import dataclass
from glob import glob
from pathlib import Path

ROOT = Path(__file__).parents[2]
PAGES = [
    ROOT / "README.md",
    ROOT / "CONTRIBUTING.md",
    ROOT / "CHANGELOG.md",
    *sorted((ROOT / "docs").rglob("*.md")),
]
_FENCE = re.compile(r"^```(\w*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
_FILE = re.compile(r"# ([\w./-]+\.\w+)\n")
_COMMENT = re.compile(r"<!--.*?-->", re.DOTALL)


def name(page):
    """Path in the project, for messages."""
    return page.relative_to(ROOT).as_posix()


def text(page):
    """Text of a page."""
    return page.read_text(encoding="utf-8")


@dataclass(frozen=True)
class Block:
    """A code block: its language, its text, the file that it is, if any, and its first line."""

    language: str
    text: str
    file: str
    line: int


def blocks(page):
    """All code blocks of a page in order."""
    whole = text(page)
    return [
        Block(
            found[1],
            found[2],
            file[1] if (file := _FILE.match(found[2])) else "",
            whole.count("\n", 0, found.start()) + 1,
        )
        for found in _FENCE.finditer(whole)
    ]


def run(page, folder):
    """Run a page's blocks in `folder`, which is the current one."""
    names = {"__name__": "__main__"}
    for block in blocks(page):
        where = f"{name(page)}, line {block.line}"
        if block.language == "text":
            continue
        if block.file:
            (folder / block.file).parent.mkdir(parents=True, exist_ok=True)
            (folder / block.file).write_text(block.text, encoding="utf-8")
        elif block.language == "toml":
            fragment(block.text, where)
        elif block.language == "python":
            exec(compile("\n" * block.line + block.text, name(page), "exec"), names)
        else:
            assert block.language == "sh", f"{where}: {block.language} is not run; is it output?"
            for line in block.text.splitlines():
                command(line, where)


def fragment(content, where):
    """Read a table [calibrate] or [diagnose] as of a campaign of the hand."""
    from hannes.core.io.toml_table import Table
    from hannes.identification.calibration.settings import KEYS as CALIBRATE
    from hannes.identification.calibration.settings import read_plan
    from hannes.identification.diagnosis.settings import KEYS as DIAGNOSE
    from hannes.identification.diagnosis.settings import read_settings
    from hannes.plants.hand.plant import HandPlant

    tables = tomllib.loads(content)
    assert tables and tables.keys() <= {"calibrate", "diagnose"}, f"{where}: of which file is it?"
    if "calibrate" in tables:
        read_plan(Table(tables["calibrate"], where, CALIBRATE), HandPlant(), ("current",))
    if "diagnose" in tables:
        read_settings(Table(tables["diagnose"], where, DIAGNOSE), HandPlant())


def command(line, where):
    """Run one line of a shell, here and now, as far as this project's commands are concerned."""
    words = [
        each
        for word in shlex.split(line, comments=True)
        for each in (sorted(glob(word)) if "*" in word else [word])
    ]
    match words:
        case []:
            pass
        case ["make", target]:
            assert re.search(rf"^{target}:", text_of_makefile(), re.MULTILINE), where
        case ["hannes", *arguments]:
            from hannes.commands.cli import main

            assert main(arguments) == 0, f"{where}: {line}"
        case ["python", "-m", "pytest" | "tools.reference", *_]:  # a process that imports anew
            subprocess.run([sys.executable, *words[1:]], check=True)
        case ["python", "-m", module, *arguments]:
            called(runpy.run_module, module, arguments)
        case ["python", file, *arguments]:
            called(runpy.run_path, file, arguments)
        case _:
            raise AssertionError(f"{where}: no test runs `{line}`")


def called(run_it, what, arguments):
    """Run a module or a file as `python` would."""
    before, sys.argv = sys.argv, [what, *arguments]
    sys.modules.pop(what, None)  # else runpy warns of a second one
    try:
        run_it(what, run_name="__main__")
    except SystemExit as end:
        assert not end.code, f"{what} ended with {end.code}"
    finally:
        sys.argv = before


def text_of_makefile():
    """Text of the Makefile."""
    return (ROOT / "Makefile").read_text(encoding="utf-8")


def prose(page):
    """Text without code blocks, comments, tables, headings and pictures; links by their words."""
    left = _COMMENT.sub("", _FENCE.sub("\n", text(page)))
    left = re.sub(r"!\[[^]]*\]\([^)]*\)", "", left)
    left = re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", left)
    lines = left.splitlines()
    return "\n".join("" if re.match(r"\s*(\||#|\$\$)", line) else line for line in lines)


def sentences(page):
    """Sentences of the prose; an item of a list ends one too."""
    left = re.sub(r"\n\s*(?:[-*]|\d+\.)\s", "\n\n", f"\n{prose(page)}")
    found = []
    for paragraph in re.split(r"\n\s*\n", left):
        whole = " ".join(paragraph.split())
        found += [
            each for each in re.split(r"(?<=[.!?:])\)?\s+(?=[\"'(`*A-Z0-9\[])", whole) if each
        ]
    return found


def tables(page):
    """Tables in Markdown as (line, rows of cells, the prose above it up to the last one)."""
    lines, found, above, k = text(page).splitlines(), [], [], 0
    while k < len(lines):
        if not lines[k].startswith("|"):
            above.append(lines[k])
            k += 1
            continue
        start = k
        while k < len(lines) and lines[k].startswith("|"):
            k += 1
        rows = [re.split(r"(?<!\\)\|", line.strip()[1:-1]) for line in lines[start:k]]
        found.append((start + 1, rows, "\n".join(above)))
        above = []
    return found
