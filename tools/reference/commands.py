"""Every command: arguments, options, examples."""

import argparse

from hannes.commands.cli import make_parser
from tools.reference.markdown import code, table

HEAD = """# Commands

`hannes COMMAND --help` shows the same.
[Exit statuses](verdicts.md#exit-statuses) stand with the verdicts.
"""


def page() -> str:
    """Text of the page."""
    (commands,) = (
        each for each in make_parser()._actions if isinstance(each, argparse._SubParsersAction)
    )
    return "\n".join([HEAD, *(_command(name, each) for name, each in commands.choices.items())])


def _command(name: str, parser: argparse.ArgumentParser) -> str:
    rows = [_row(each) for each in parser._actions if not isinstance(each, argparse._HelpAction)]
    shown = f"{table(('argument', 'is'), rows)}\n\n" if rows else ""
    examples = (parser.epilog or "").removeprefix("examples:\n")
    lines = "\n".join(line.removeprefix("  ") for line in examples.splitlines())
    about = (parser.description or "").strip()
    return f"## hannes {name}\n\n{about[:1].upper()}{about[1:]}.\n\n{shown}```text\n{lines}\n```\n"


def _row(action: argparse.Action) -> tuple[str, str]:
    shown = action.metavar or action.dest.upper()
    if action.option_strings:
        value = "" if action.nargs == 0 else f" {shown}"
        return code(f"{action.option_strings[-1]}{value}"), action.help or ""
    return code(shown if action.metavar else action.dest), action.help or ""
