"""Progress bars: seen in a terminal and a notebook, silent in a pipe."""

import io
import sys
from types import SimpleNamespace

import pytest

from hannes.core.io.progress import in_notebook, progress_bar, stages


class ZMQInteractiveShell:
    """Stands for the shell of a notebook's kernel, known by its class."""

    config: dict = {}  # noqa: RUF012


@pytest.fixture
def notebook(monkeypatch):
    fake = SimpleNamespace(get_ipython=ZMQInteractiveShell, version_info=(8,))
    monkeypatch.setitem(sys.modules, "IPython", fake)


def shown(**options):
    stream = io.StringIO()
    for _ in progress_bar(range(3), "counting", file=stream, **options):
        pass
    return stream.getvalue()


def test_a_pipe_stays_silent():
    assert not in_notebook()
    assert shown() == ""


def test_a_notebook_shows_it_though_its_stream_is_no_terminal(notebook):
    assert in_notebook()
    assert "counting: 100%" in shown()
    assert shown(disable=True) == ""


def test_stages_are_lines_in_a_pipe_where_asked_for(capsys):
    for shown in (None, False, True):
        with stages("working", " steps", shown) as report:
            for stage, detail in (("one", "1"), ("one", "2"), ("two", ""), ("one", "3")):
                report(stage, detail)
        printed = capsys.readouterr()
        assert printed.out == ""
        if not shown:
            assert printed.err == ""
    assert printed.err.splitlines() == [
        "working, 0 s: one, 1", "working, 0 s: two", "working, 0 s: one, 3"
    ]  # fmt: skip


def test_stages_move_a_bar_in_a_terminal(monkeypatch):
    terminal = io.StringIO()
    terminal.isatty = lambda: True
    monkeypatch.setattr(sys, "stderr", terminal)
    monkeypatch.setattr("hannes.core.io.progress.DELAY", 0.0)
    with stages("working", " steps", True) as report:
        report("one", "1")
        report("two", "")
    assert "\rworking: 0 steps" in terminal.getvalue() and "\n" not in terminal.getvalue()
