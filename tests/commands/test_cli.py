"""The command line: help with examples that parse, one JSON object, exit statuses, Ctrl-C."""

import argparse
import json
import re
import shlex
from pathlib import Path

import pytest

from hannes import __version__
from hannes.commands import cli
from hannes.commands.cli import main
from hannes.commands.cli_examples import EXAMPLES
from hannes.commands.edge import INTERRUPTED, UNFORESEEN
from hannes.core.io.atomic_files import atomic_folder

SHORT = """
duration = "20 ms"
[reference]
kind = "ramp"
points = [["0 s", "0 rad"], ["1 s", "15 rad"]]
"""


def commands():
    """Parser of each command by name."""
    (found,) = [
        action
        for action in cli.make_parser()._actions
        if isinstance(action, argparse._SubParsersAction)
    ]
    return found.choices


def examples(name):
    """Command lines that the help of a command shows."""
    lines = [line.strip() for line in EXAMPLES[name].splitlines()]
    return [line for line in lines if line.startswith("hannes ")]


def words(line):
    """Arguments of an example, without what the shell does with them and what it says of them."""
    return shlex.split(line.split("  ")[0].split("|")[0].split(">")[0].replace("*", "1"))[1:]


@pytest.mark.parametrize("name", ["", *commands()])
def test_every_command_has_help_with_examples(capsys, name):
    with pytest.raises(SystemExit) as stopped:
        main([*([name] if name else []), "--help"])
    assert stopped.value.code == 0
    printed = capsys.readouterr()
    assert "examples:" in printed.out and printed.err == ""
    assert examples(name) and all(line in printed.out for line in examples(name))


@pytest.mark.parametrize("line", [line for name in ["", *commands()] for line in examples(name)])
def test_every_example_is_a_command_that_parses(line):
    assert cli.make_parser().parse_args(words(line)).command in commands()


@pytest.mark.parametrize("name", commands())
def test_every_option_and_argument_is_explained(name):
    unexplained = [each.dest for each in commands()[name]._actions if not each.help]
    assert unexplained == []


def test_no_command_prints_the_help(capsys):
    assert main([]) == 0
    printed = capsys.readouterr().out
    assert all(name in printed for name in commands())


def test_the_version(capsys):
    with pytest.raises(SystemExit):
        main(["--version"])
    assert capsys.readouterr().out == f"hannes {__version__}\n"


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["rnu"], 'no command "rnu"; did you mean "run"?'),
        (["run"], "the following arguments are required: experiment"),
        (["run", "dynamometre"], 'did you mean "dynamometer"?'),
        (["run", "dynamometer", "--rtol", "small"], "argument --rtol"),
        (["run", "dynamometer", "--rtol", "-1"], "rtol = -1"),
        (["run", "dynamometer", "--method", "Rodass"], 'did you mean "Rodas"?'),
        (["run", "dynamometer", "--metod", "Rodas"], "unrecognized arguments: --metod"),
        (["effects", "leader_slak"], 'did you mean "leader_slack"?'),
        (["diagnose", "nowhere.toml"], "nowhere.toml: expected a TOML file, there is no such file"),
        (["dataset", "large", "--grasp", "1", "--backend", "dask"], "--grasp makes one, here"),
        (
            ["check", "emps", "--plant", "axis"],
            "a campaign names plant, experiments and mappings itself",
        ),
        (["reproduce", "--slack", "nowhere"], "is no verdict of a diagnosis"),
    ],
)
def test_bad_arguments_are_one_line(tmp_path, monkeypatch, capsys, arguments, said):
    monkeypatch.chdir(tmp_path)
    assert main(arguments) == 2
    printed = capsys.readouterr()
    assert printed.out == "" and printed.err.count("\n") == 1
    assert printed.err.startswith("hannes: ") and said in printed.err
    assert list(tmp_path.iterdir()) == []


def test_json_is_one_object_and_nothing_else(tmp_path, monkeypatch, capsys):
    """The other commands with --json are run whole in their own tests."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "my.toml").write_text(SHORT, encoding="utf-8")
    assert main(["run", "my.toml", "--json"]) == 0
    printed = json.loads(capsys.readouterr().out)
    kept = json.loads((tmp_path / "results" / "my" / "summary.json").read_text(encoding="utf-8"))
    assert printed == kept and printed["runs"][0]["outcome"] == "completed"


def test_run_in_words_says_where_the_results_are(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "my.toml").write_text(SHORT, encoding="utf-8")
    assert main(["run", "my.toml", "--out", "here"]) == 0
    assert capsys.readouterr().out.endswith("wrote here/\n")
    found = {each.name for each in (tmp_path / "here").iterdir()}
    assert found >= {"recording.h5", "summary.json", "figure.svg"}


def test_effects_and_experiments_list_what_there_is(capsys):
    from hannes.simulation.catalogue import effects
    from hannes.simulation.experiment import shipped

    assert main(["effects"]) == main(["experiments"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert {*effects(), *shipped.names()} <= set(lines)
    for name, each in effects().items():
        assert main(["effects", name]) == 0
        printed = capsys.readouterr().out
        assert each.equation in printed and each.source in printed and each.meaning in printed


def test_ctrl_c_is_one_line_and_keeps_earlier_results(tmp_path, monkeypatch, capsys):
    import hannes.commands.run

    with atomic_folder(tmp_path / "out", "run") as folder:
        (folder / "summary.json").write_text("{}")

    def stopped(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(hannes.commands.run, "observe", stopped)
    (tmp_path / "my.toml").write_text(SHORT, encoding="utf-8")
    asked = ["run", str(tmp_path / "my.toml"), "--out", str(tmp_path / "out")]
    assert main(asked) == INTERRUPTED
    printed = capsys.readouterr()
    assert printed.out == "" and "hannes: interrupted" in printed.err
    assert (tmp_path / "out" / "summary.json").read_text() == "{}"


def test_an_error_that_nobody_foresaw_is_one_line_and_keeps_its_details(monkeypatch, capsys):
    """What was done, where the traceback is, what to do with it; exit status 70."""
    from hannes.simulation.experiment import shipped

    monkeypatch.setattr(shipped, "names", lambda: 1 / 0)
    assert main(["experiments"]) == UNFORESEEN
    printed = capsys.readouterr()
    assert printed.out == "" and printed.err.count("\n") == 1
    assert "`hannes experiments`" in printed.err and "please report it" in printed.err
    kept = Path(re.search(r"details are in (\S+):", printed.err)[1])
    assert "ZeroDivisionError" in kept.read_text() and "Traceback" in kept.read_text()
    kept.unlink()
