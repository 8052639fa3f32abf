"""What a live grasp looks like in a terminal, narrow and wide, and in a pipe."""

import io

import pytest
from rich.console import Console

from hannes.bench.grip_loop import Force
from hannes.bench.live import Decision
from hannes.bench.live_display import BARS, Picture, PlainLines, trace
from hannes.bench.live_run import Moment
from hannes.recognition.model import Estimate


def moments(count=300, released=False):
    """Moments of a grasp whose numbers are as long as they get."""
    made = []
    for k in range(count):
        decision = Decision(
            0.01 * k, 100.0 + 0.01 * k, "don't know", 0.55, True, 5.0, True,
            Estimate(38300.0, 12345.0, 98765.0), Estimate(123.4, 100.0, 150.0),
        )  # fmt: skip
        values = {"position": 0.03 * k, "current": 0.4 + 0.001 * k}
        said = None if released else decision
        force = Force(1.0, 123.4, 100.0, 150.0, 12.3, True)
        time = 100.0 + 0.01 * k
        made.append(Moment(time, values, said, force, None, True, 9.0, released, 12345, 678))
    return made


def drawn(wide, kept):
    """Lines of the picture in a terminal so wide."""
    text = io.StringIO()
    Console(file=text, width=wide, height=24, force_terminal=False).print(Picture("x", kept))
    return text.getvalue().splitlines()


@pytest.mark.parametrize("wide", [80, 120, 200])
def test_nothing_is_cut_off_or_wrapped(wide):
    lines = drawn(wide, moments())
    assert {len(line) for line in lines} == {wide} and len(lines) <= 12
    text = "\n".join(lines)
    assert "…" not in text
    for words in (
        "8.97 rad", "123.4 N (100.0 to 150.0)", "38300 N/m (12345 to 98765)", "held firmly",
        "the machine has left the model", "damaged 12345, gaps 678; stop: Ctrl-C", "P(rigid) 0.55",
    ):  # fmt: skip
        assert words in text


def test_a_trace_fills_its_width_and_noise_stays_flat():
    assert trace([float(k) for k in range(600)], 40, 1.0)[::39] == BARS[0] + BARS[-1]
    assert len(trace([float(k) for k in range(600)], 40, 1.0)) == 40
    assert len(trace([1.0, 2.0], 40, 1.0)) == 2
    assert set(trace([0.0, 0.01] * 50, 40, 1.0)) == {BARS[0]}


def test_what_is_let_go_is_no_longer_shown():
    assert "nothing held" in "\n".join(drawn(80, moments(released=True)))


def test_a_pipe_gets_a_line_when_the_word_changes_and_when_it_is_let_go(capsys):
    shown = PlainLines()
    for moment in [*moments(30), *moments(3, released=True)[:1]]:
        shown.put(moment)
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 3 and "don't know" in lines[0] and lines[2].endswith("let go")
