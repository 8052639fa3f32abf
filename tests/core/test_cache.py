"""Machine code on disk: whole or made anew, by one process, elsewhere where it must be."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from hannes.core.io.cache import cache_home

SOURCE = """\
from hannes.core.kernels.jit import entry

@entry
def asked(x):
    return 2.0 * x + 1.0
"""
ASK = """
import sys
sys.path.insert(0, sys.argv[1])
import asked_for
print(asked_for.asked(3.0), sum(asked_for.asked.stats.cache_hits.values()))
"""
AGAIN = ASK + "del sys.modules['asked_for']" + ASK  # as another process reads what is kept


@pytest.fixture
def folder(tmp_path, compiling):
    (tmp_path / "asked_for.py").write_text(SOURCE)
    return tmp_path


def started(folder, script=ASK, **environment):
    path = os.pathsep.join([str(Path(__file__).parents[2]), *filter(None, sys.path)])
    known = {"HANNES_CACHE": str(folder / "cache"), "PYTHONPATH": path}
    return subprocess.Popen(
        [sys.executable, "-c", script, str(folder)],
        env={**os.environ, **known, **environment},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def asked(folder, script=ASK):
    """What the function says, and whether its code was found."""
    run = started(folder, script)
    out, printed = run.communicate()
    assert run.returncode == 0 and printed == "", printed
    return out.split()


def entries(folder):
    return sorted(each for each in (folder / "__pycache__").iterdir() if ".nb" in each.name)


@pytest.fixture(scope="module")
def kept(tmp_path_factory, compiling):
    """A folder with machine code that one process made and another found."""
    folder = tmp_path_factory.mktemp("kept")
    (folder / "asked_for.py").write_text(SOURCE)
    assert asked(folder) == ["7.0", "0"]
    assert asked(folder) == ["7.0", "1"]
    return folder


@pytest.mark.parametrize(
    ("suffix", "damage"),
    [(".nbi", "cut"), (".nbi", "bit"), (".nbc", "cut"), (".nbc", "bit"), (".nbc", "gone")],
)
def test_damaged_machine_code_is_made_anew(kept, suffix, damage):
    (entry,) = [each for each in entries(kept) if each.suffix == suffix]
    data = bytearray(entry.read_bytes())
    data[len(data) // 2] ^= 1
    changed = {"cut": data[: len(data) // 2], "bit": data, "empty": b""}
    entry.unlink() if damage == "gone" else entry.write_bytes(changed[damage])
    assert asked(kept, AGAIN) == ["7.0", "0", "7.0", "1"]


def test_two_processes_on_a_cold_cache_share_what_one_compiles(folder):
    runs = [started(folder) for _ in range(2)]
    found = [run.communicate()[0].split() for run in runs]
    assert sorted(found) == [["7.0", "0"], ["7.0", "1"]]


def test_another_version_of_numba_never_reads_the_old_ones(folder):
    digest = "from hannes.core.kernels.jit import compiler_digest\nprint(compiler_digest())\n"
    other = "import numba\nnumba.__version__ = '0.0.1'\n"
    now, then = (asked(folder, before + ASK + digest) for before in ("", other))
    assert now[:2] == then[:2] == ["7.0", "0"]
    assert len(now) == len(then) == 3 and now[2] != then[2]


HOME = """
from hannes.core.io.cache import cache_home
from hannes.core.io.units import quantity
one, two = cache_home(), cache_home()
assert one == two and one.is_dir() and quantity("3.1 mm", "m", "x") == 0.0031
print(one)
"""


@pytest.mark.parametrize("place", ["file", "/proc/nowhere", "x" * 300, "nul"])
def test_a_cache_that_cannot_be_written_is_one_line_and_a_temporary_one(tmp_path, place):
    (tmp_path / "file").write_text("in the way")
    given = str(tmp_path / "file") if place == "file" else place
    run = started(tmp_path, HOME, HANNES_CACHE=given if place != "nul" else "/dev/null/x")
    out, printed = run.communicate()
    assert run.returncode == 0 and printed.count("\n") == 1, printed
    assert "no cache can be kept" in printed and "set HANNES_CACHE" in printed
    assert "hannes-cache-" in out and not Path(out.strip()).exists()  # it went with the process


def test_a_home_that_is_missing_is_one_line_and_a_temporary_one(tmp_path):
    run = started(tmp_path, HOME, HANNES_CACHE="", XDG_CACHE_HOME="", HOME="/proc/nowhere")
    out, printed = run.communicate()
    assert run.returncode == 0 and printed.count("\n") == 1 and "hannes-cache-" in out


FULL = """
import resource, sys
resource.setrlimit(resource.RLIMIT_FSIZE, (2000, 2000))
from hannes.commands.cli import main
sys.exit(main(["run", "dynamometer", "--out", sys.argv[1] + "/out"]))
"""


@pytest.mark.skipif(os.name == "nt", reason="needs limits of POSIX")
def test_a_disk_that_is_full_is_one_line_and_exit_status_2(tmp_path):
    run = started(tmp_path, FULL)
    out, printed = run.communicate()
    lines = [each for each in printed.splitlines() if "no cache can be kept" not in each]
    assert run.returncode == 2 and out == "" and len(lines) == 1 and "cannot write" in lines[0]
    assert not (tmp_path / "out").exists()


def test_the_cache_of_these_tests_is_one():
    assert cache_home().is_dir()
