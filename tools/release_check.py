"""What a release has to do, from an empty folder: `python -m tools.release_check`.

Builds wheel and sdist; the wheel that the sdist gives has to hold the same files. Installs the
wheel with requirements.lock into a fresh environment, with an empty cache, and runs every `hannes`
line of the README in an empty folder, in the README's order; every command has to be among them.
Then `make run` and `make test` in a fresh clone (`--clone`: that alone, `--wheel`: all but that).
"""

import argparse
import os
import re
import shlex
import subprocess
import sys
import tempfile
import time
import zipfile
from collections.abc import Iterable
from pathlib import Path

ROOT = Path(__file__).parents[1]
LINE = re.compile(r"^((?:hannes|python -m benchmarks\.truth)[^\n#`]*)", re.MULTILINE)
# Shown by their help alone: they need a port, or the library of an extra, which no lock has.
BY_HELP = ("board", "record", "port", "live", "panel", "fmu")
RIG = """\
plant = "hand"
experiment = "void-closure"
[time]
column = "t [ms]"
unit = "ms"
[channels.current]
column = "i [mA]"
unit = "mA"
[channels.position]
column = "angle [deg]"
unit = "deg"
"""
CAMPAIGN = """\
plant = "hand"
[[recording]]
file = "run.csv"
experiment = "void-closure"
"""


def readme_lines(text: str) -> list[str]:
    """Commands in a README's tables and fenced blocks, in order, once each."""
    found: dict[str, None] = {}
    fenced = False
    for line in text.splitlines():
        if line.startswith("```"):
            fenced = not fenced
        shown = [line] if fenced else re.findall(r"`([^`]+)`", line) if line[:1] == "|" else []
        for each in shown:
            if command := LINE.match(each):
                found[command[1].strip()] = None
    return list(found)


def commands(help_text: str) -> list[str]:
    """Names of the commands that `hannes --help` lists."""
    table = help_text.partition("  COMMAND\n")[2].partition("\n\n")[0]
    return re.findall(r"^    ([a-z][\w-]*)", table, flags=re.MULTILINE)


def runnable(words: list[str]) -> list[str]:
    """The command itself, or its help where it would wait for a machine at a port."""
    return [*words[:2], "--help"] if words[1] in BY_HELP else words


def missing(lines: Iterable[str], names: Iterable[str]) -> list[str]:
    """Commands that no line of the README runs."""
    run = {shlex.split(line)[1] for line in lines if line.startswith("hannes ")}
    return sorted(set(names) - run)


def ran(command: list[str], folder: Path, path: Path | None = None, **variables: str) -> str:
    """Run a command in a folder and print how long it took; ends the check where it fails."""
    start, shown = time.monotonic(), " ".join(command)
    environment = {name: os.environ[name] for name in os.environ if name != "PYTHONPATH"}
    if path is not None:
        environment["PATH"] = f"{path}{os.pathsep}{environment['PATH']}"
    done = subprocess.run(
        command,
        cwd=folder,
        env=environment | variables,
        capture_output=True,
        text=True,
        check=False,
    )
    print(f"{time.monotonic() - start:7.1f} s  {shown}", flush=True)
    if done.returncode:
        sys.exit(f"{shown} in {folder}: status {done.returncode}\n{done.stdout}{done.stderr}")
    return done.stdout


def contents(wheel: Path) -> dict[str, bytes]:
    """Files of a wheel."""
    with zipfile.ZipFile(wheel) as archive:
        return {name: archive.read(name) for name in sorted(archive.namelist())}


def built(folder: Path) -> Path:
    """Wheel and sdist in `folder`; the sdist's own wheel is the same. Returns the wheel."""
    python = sys.executable
    ran([python, "-m", "hatchling", "build", "-d", str(folder)], ROOT)
    (sdist,), (wheel,) = folder.glob("*.tar.gz"), folder.glob("*.whl")
    again = folder / "again"
    options = ["--no-deps", "--no-build-isolation", "--no-cache-dir", "--quiet"]
    ran([python, "-m", "pip", "wheel", *options, "-w", str(again), str(sdist)], folder)
    if contents(wheel) != contents(next(again.glob("*.whl"))):
        sys.exit("the wheel that the sdist gives is not the one of the checkout")
    return wheel


def installed(wheel: Path, folder: Path) -> Path:
    """Fresh environment with the locked core and the wheel; returns the folder of its commands."""
    ran([sys.executable, "-m", "venv", str(folder)], ROOT)
    pip = [str(folder / "bin" / "python"), "-m", "pip", "install", "--quiet"]
    ran([*pip, "-r", str(ROOT / "requirements.lock")], ROOT)
    ran([*pip, "--no-deps", str(wheel)], ROOT)
    return folder / "bin"


def write_log(folder: Path) -> None:
    """A closure as another logger has it: log.csv."""
    from hannes import Hand, load_experiment, observe, simulate

    (shipped,) = load_experiment("void-closure")
    found = observe(Hand(), simulate(Hand(), shipped.experiment))
    rows = zip(found.time, found["current"], found["position"], strict=True)
    text = "".join(f"{1e3 * t:.3f},{1e3 * i:.4f},{57.2957795 * q:.5f}\n" for t, i, q in rows)
    (folder / "log.csv").write_text("t [ms],i [mA],angle [deg]\n" + text, encoding="utf-8")


def inputs(folder: Path) -> None:
    """Files that the README's lines take for granted: another logger's, a campaign, objects."""
    write_log(folder)
    (folder / "rig.toml").write_text(RIG, encoding="utf-8")
    (folder / "campaign.toml").write_text(CAMPAIGN, encoding="utf-8")
    objects = [sys.executable, "-m", "benchmarks.truth.objects", "--out", ".", "--grasps", "2"]
    ran(objects, folder, PYTHONPATH=str(ROOT))


def check_wheel(folder: Path) -> None:
    """Build, install, and run every line of the README where nothing else is."""
    lines = readme_lines((ROOT / "README.md").read_text(encoding="utf-8"))
    scripts = installed(built(folder / "built"), folder / "environment")
    empty = folder / "empty"
    empty.mkdir()
    quiet = {"HANNES_CACHE": str(folder / "cache")}
    names = commands(ran(["hannes", "--help"], empty, scripts, **quiet))
    if left := missing(lines, names):
        sys.exit(f"no line of README.md runs: {', '.join(left)}")
    inputs(empty)
    for line in lines:
        words = shlex.split(line)
        if words[0] == "hannes":
            ran(runnable(words), empty, scripts, **quiet)
        else:  # the second simulator is part of a checkout, not of an installation
            ran([sys.executable, *words[1:]], empty, PYTHONPATH=str(ROOT))


def check_clone(folder: Path) -> None:
    """`make run` and `make test` in a fresh clone with an empty cache."""
    ran(["git", "clone", "--quiet", str(ROOT), str(folder / "clone")], folder)
    for target in ("run", "test"):
        ran(["make", target], folder / "clone", HANNES_CACHE=str(folder / f"cache-{target}"))


def main() -> None:
    """Check what is asked for, all by default."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--wheel", action="store_true")
    parser.add_argument("--clone", action="store_true")
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        for name, check in (("wheel", check_wheel), ("clone", check_clone)):
            if getattr(asked, name) or not (asked.wheel or asked.clone):
                check(Path(folder))
    print("all of it works")


if __name__ == "__main__":
    main()
