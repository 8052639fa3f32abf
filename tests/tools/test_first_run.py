"""`make run`: steps in order, at once where they can be, ended together; every command is one."""

import shlex
import time

import pytest

from hannes.commands.cli import make_parser
from tools.first_run import STEPS, Run, Step

SLEEP = 'timeit -n 1 -r 1 "import time; time.sleep({})"'


def test_steps_are_in_order_and_of_commands_that_there_are():
    known = set()
    for each in STEPS:
        assert set(each.after) <= known, each.name
        known.add(each.name)
        module, *words = shlex.split(each.command)
        if module == "hannes":
            assert make_parser().parse_args(words).call
    assert len(known) == len(STEPS) and STEPS[-1].page


def test_pages_come_early_and_the_first_says_what_is_coming():
    pages = [each for each in STEPS if each.page]
    assert pages[0].command.startswith("hannes diagnose")
    assert "--coming emps recognition" in pages[1].command
    assert "--coming" not in pages[-1].command and pages[-1] is STEPS[-1]


def test_steps_that_need_none_run_at_once_and_others_wait(capsys):
    steps = (
        Step("one", SLEEP.format(0.3)),
        Step("two", SLEEP.format(0.3)),
        Step("both", SLEEP.format(0.0), ("one",), 2, "a page"),
    )
    assert Run(steps, 2)() == 0
    said = [line.split("s  ", 1)[1] for line in capsys.readouterr().out.splitlines()]
    assert said[:2] == ["one: begins", "two: begins"]
    assert said[-1] == "both: open a page" and said.index("both: begins") >= 4


def test_a_step_that_fails_ends_the_others(capsys):
    steps = (Step("long", SLEEP.format(60)), Step("bad", "no_such_module"), Step("never", "this"))
    begun = time.monotonic()
    assert Run(steps, 2)() == 1
    assert time.monotonic() - begun < 30.0
    said = capsys.readouterr().out
    assert "bad: ended with status 1" in said and "never" not in said


@pytest.mark.parametrize("cores", [1, 2])
def test_a_step_for_two_cores_runs_where_there_is_one(cores):
    assert Run((Step("both", SLEEP.format(0.0), (), 2),), cores)() == 0
