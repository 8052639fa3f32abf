"""Progress bars: seen in a terminal and a notebook, silent in a pipe."""

import io
import sys
from types import SimpleNamespace

import pytest

from hannes.core.io.progress import in_notebook, progress_bar


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
