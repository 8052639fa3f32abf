"""The command `hannes`: parses, calls the library, prints; libraries load where they are used."""

import argparse
import json
import os
import sys
import textwrap
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, NoReturn

from hannes import __version__
from hannes.commands import cli_learning, cli_recordings
from hannes.core.errors import BadInput, HannesError, Interrupted, nearest
from hannes.simulation.compiler.kernel_error import blamed

INTERRUPTED, PIPE_CLOSED = 130, 141  # what a shell reports for SIGINT and SIGPIPE

DESCRIPTION = "A model of the Hannes prosthetic hand that says what it is missing."
EXAMPLES = {
    "": """\
hannes run dynamometer           simulate a shipped experiment, write results/dynamometer
hannes experiments               what there is to run
hannes reproduce                 the paper's figures and tables beside ours, one page
hannes calibrate campaign.toml   parameters from recordings, with intervals that hold
hannes diagnose campaign.toml    what a model is missing that recordings disagree with""",
    "run": """\
hannes run void-closure
hannes run my.toml --out results/mine
hannes run dynamometer --method Radau --rtol 1e-6 --json""",
    "experiments": """\
hannes experiments""",
    "effects": """\
hannes effects
hannes effects leader_slack
hannes effects my_effect.py:EFFECT""",
    "hand": """\
hannes hand
hannes hand results/closure/hand.toml
hannes hand --equations | less""",
    "reproduce": """\
hannes reproduce
hannes reproduce --out results/paper --json""",
    "calibrate": """\
hannes calibrate campaign.toml
hannes calibrate campaign.toml --out results/mine --json

campaign.toml, after its [[recording]]s; all of it may be left out:
  [calibrate]
  parameters = ["motor.resistance", "motor.dry_friction"]
  channels = ["current", "position"]
  features = ["closing time", "I_max"]    # of the paper's Table II
  loss = "soft_l1"                        # linear, soft_l1, huber, cauchy
  starts = 4                              # searches from different points
  scan = 64                               # points looked at before them
  doubt = "2 %"                           # how far off all values may be that are not fitted
  limit = "10 %"                          # half an interval beyond which nothing is identified
  model_error = "1 %"                     # share of a channel in which no model is believed
  accept = ["gap", "saturated"]           # what `hannes check` finds, taken as it is
  [calibrate.spread]                      # how far off a given value may be, 1 deviation
  "motor.resistance" = "20 %"
  [calibrate.bounds]
  "motor.resistance" = ["2 ohm", "5 ohm"]
  [calibrate.nuisance]                    # what differs from run to run, 1 deviation
  start_time = "10 ms"
  "motor.dry_friction" = "1 %\"""",
    "diagnose": """\
hannes diagnose campaign.toml
hannes diagnose campaign.toml --out results/verdict --json

campaign.toml (docs/campaign.md has all of it):
  plant = "hand"                          # or "axis", "finger", "module:Class" of your own
  effects = ["my_effect.py:EFFECT"]       # beside those of `hannes effects`
  [[recording]]
  file = "void_*.csv"                     # repeats under one command
  experiment = "void-closure"             # what was done: a shipped name, or a .toml
  condition = "void, full speed"
  role = "fit"                            # or select, show; drawn where absent
  [diagnose]                              # standard deviations; may be left out
  scatter = "2 %"                         # of given values (3 %)
  run_scatter = "0.5 %"                   # of friction from run to run (1 %)
  start_time = "0.2 ms"                   # of when a run starts (10 ms)""",
    **cli_recordings.EXAMPLES,
    **cli_learning.EXAMPLES,
}


class _Parser(argparse.ArgumentParser):
    """Reports errors as every other bad input: one line, exit status 2."""

    def error(self, message: str) -> NoReturn:
        raise BadInput(f"{message}; see `{self.prog} --help`")

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        """As argparse, but with the nearest match instead of a long list of choices."""
        if action.choices is not None and value not in action.choices:
            names = [str(each) for each in action.choices]
            what = "command" if action.dest == "command" else action.dest
            self.error(f'no {what} "{value}"{nearest(value, names)} ({", ".join(names)})')


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command; return its exit status (0 done, 2 bad input, 3 computation failed)."""
    try:
        return _run(arguments)
    except HannesError as error:
        print(f"hannes: {_one_line(error)}", file=sys.stderr)
        return error.exit_status
    except KeyboardInterrupt:
        print("hannes: interrupted; earlier results are as they were", file=sys.stderr)
        return INTERRUPTED
    except BrokenPipeError:
        # Whoever read us has gone; Python would complain once more when it flushes at exit.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return PIPE_CLOSED


def _run(arguments: Sequence[str] | None) -> int:
    parser = _parser()
    chosen = parser.parse_args(arguments)
    if chosen.command is None:
        parser.print_help()
        return 0
    try:
        chosen.call(chosen)
    except Exception as error:
        if (told := blamed(error)) is None:
            raise
        raise told from None
    sys.stdout.flush()
    return 0


def _one_line(error: Exception) -> str:
    text = " ".join(str(error).split())
    return "".join(each if each.isprintable() else "?" for each in text)


def _parser() -> _Parser:
    parser = _Parser(prog="hannes", description=DESCRIPTION, **_with_examples(""))
    parser.add_argument("--version", action="version", version=f"hannes {__version__}")
    commands = parser.add_subparsers(dest="command", metavar="COMMAND", parser_class=_Parser)

    run = _command(commands, "run", _run_experiment, "simulate an experiment and write its results")
    run.add_argument("experiment", help="a shipped experiment's name, or a .toml file")
    _results(run, "results/<experiment>")
    run.add_argument("--method", default="Rodas", help="Rodas (default) or one of scipy's")
    run.add_argument("--rtol", type=float, default=1e-4, help="relative tolerance (default 1e-4)")

    _command(commands, "experiments", _experiments, "list the shipped experiments")

    effects = _command(commands, "effects", _effects, "list the effects, or tell all about one")
    effects.add_argument("effect", nargs="?", help="a name, or file.py:EFFECT of your own")
    effects.add_argument("--plant", metavar="PLANT", help="those that this plant alone has")

    hand = _command(commands, "hand", _hand, "show a hand: parts, equations, effects, values")
    hand.add_argument(
        "hand", nargs="?", default="hannes", help="a hand.toml, of any plant (default: shipped)"
    )
    hand.add_argument("--equations", action="store_true", help="print the assembled equations")
    hand.add_argument("--values", action="store_true", help="print every value with its source")

    reproduce = _command(commands, "reproduce", _reproduce, "the paper's results beside ours")
    _results(reproduce, "results/reproduce")
    reproduce.add_argument(
        "--slack", metavar="FOLDER", help="results of a diagnosis of closures with hidden slack"
    )
    reproduce.add_argument(
        "--taut", metavar="FOLDER", help="results of a diagnosis of the same closures without it"
    )
    reproduce.add_argument(
        "--recognition", metavar="FOLDER", help="results of an evaluation of the ten objects"
    )

    calibrate = _command(commands, "calibrate", _calibrate, "fit parameters, with intervals")
    calibrate.add_argument("campaign", help="a campaign's .toml file")
    _results(calibrate, "as the campaign says")

    diagnose = _command(commands, "diagnose", _diagnose, "say what a model is missing")
    diagnose.add_argument("campaign", help="a campaign's .toml file")
    _results(diagnose, "as the campaign says")

    cli_recordings.add(partial(_command, commands))
    cli_learning.add(partial(_command, commands))
    return parser


def _command(
    commands: Any, name: str, call: Callable[[argparse.Namespace], None], told: str
) -> _Parser:
    parser = commands.add_parser(name, help=told, description=told, **_with_examples(name))
    parser.set_defaults(call=call)
    return parser


def _with_examples(name: str) -> dict[str, Any]:
    lines = "\n".join(f"  {line}" for line in EXAMPLES[name].splitlines())
    return {
        "epilog": f"examples:\n{lines}",
        "formatter_class": argparse.RawDescriptionHelpFormatter,
        "allow_abbrev": False,
    }


def _results(parser: _Parser, default: str) -> None:
    parser.add_argument("--out", metavar="FOLDER", help=f"folder of the results ({default})")
    parser.add_argument("--json", action="store_true", help="print one JSON object, nothing else")


def _run_experiment(chosen: argparse.Namespace) -> None:
    from hannes.commands.run import run

    summary = run(chosen.experiment, chosen.out, method=chosen.method, rtol=chosen.rtol)
    if chosen.json:
        _print_json(summary)
    else:
        print(_told(summary))


def _told(summary: dict[str, Any]) -> str:
    """A run's results for a terminal."""
    lines = [summary["title"]]
    for each in summary["runs"]:
        if each["name"]:
            lines.append(f"  {each['name']}")
        for name, figure in {**each.get("metrics", {}), **each.get("peaks", {})}.items():
            value = "-" if figure["value"] is None else f"{figure['value']:.4g} {figure['unit']}"
            lines.append(f"    {name:<16} {value}")
        if "residual" in (energy := each.get("energy", {})):
            left = 100.0 * abs(energy["residual"]["value"])
            lines.append(f"    {'energy closes to':<16} {left:.2g} %")
    return "\n".join([*lines, f"wrote {summary['out']}/"])


def _experiments(chosen: argparse.Namespace) -> None:
    from hannes.simulation.experiment import shipped

    for name in shipped.names():
        print(name)
        told = shipped.question(shipped.find(name))
        print(textwrap.fill(told, 78, initial_indent="  ", subsequent_indent="  "))


def _effects(chosen: argparse.Namespace) -> None:
    from pathlib import Path

    from hannes.identification import confusability
    from hannes.plants.protocol import find_plant
    from hannes.simulation import catalogue
    from hannes.simulation.hand.hand_file import own_catalogue

    found = find_plant(chosen.plant, Path.cwd()) if chosen.plant else None
    known = catalogue.effects() if found is None else own_catalogue(found)
    if chosen.effect:
        print(known.get(chosen.effect) or catalogue.effect(chosen.effect))
        if found is None and (near := confusability.told(chosen.effect)):
            print(near)
        return
    for each in known.values():
        told = textwrap.fill(each.meaning, 78, initial_indent="  ", subsequent_indent="  ")
        print(f"{each.name}\n{told}\n  {each.equation}\n  source: {each.source}")


def _hand(chosen: argparse.Namespace) -> None:
    from hannes.plants.plant_file import load_model
    from hannes.simulation.hand.description import (
        described,
        equations_of,
        plant_described,
        value_table,
    )
    from hannes.simulation.hand.hand import Hand

    model = load_model(chosen.hand)
    if chosen.equations:
        print(equations_of(model))
    elif chosen.values:
        print(value_table(model))
    else:
        print(described(model) if isinstance(model, Hand) else plant_described(model, model.name))


def _reproduce(chosen: argparse.Namespace) -> None:
    from hannes.commands.reproduce import reproduce

    out = chosen.out or "results/reproduce"
    given = {"slack": chosen.slack, "taut": chosen.taut, "recognition": chosen.recognition}
    found = reproduce(out, **given)
    if chosen.json:
        _print_json(found)
        return
    for row in found["must_show"]:
        verdict = "holds" if row["holds"] else "DOES NOT HOLD"
        print(
            f"  {row['name']}: {row['value']:.3g} {row['unit']} (<= {row['bound']:.3g}) {verdict}"
        )
    holds = sum(row["holds"] for row in found["must_show"])
    print(f"{holds} of {len(found['must_show'])} figures hold")
    print(f"open {out}/index.html")


def _calibrate(chosen: argparse.Namespace) -> None:
    from hannes.campaigns.campaign_file import read_campaign
    from hannes.commands.calibrate import calibrate

    campaign = read_campaign(chosen.campaign)
    out = chosen.out or campaign.out
    result = calibrate(campaign, out=out)
    if chosen.json:
        _print_json(result.plain())
    else:
        print(f"{result.summary()}\nopen {out}/report.html")
    if result.found.interrupted:
        raise Interrupted(f"interrupted; the best so far stands in {out}")


def _diagnose(chosen: argparse.Namespace) -> None:
    from hannes.campaigns.campaign_file import read_campaign
    from hannes.commands.diagnose import diagnose

    campaign = read_campaign(chosen.campaign)
    out = chosen.out or campaign.out
    result = diagnose(campaign, out=out)
    if chosen.json:
        _print_json(json.loads(result.verdict.json()))
        return
    print(result.verdict.summary())
    print(f"open {out}/report.html")


def _print_json(content: Any) -> None:
    print(json.dumps(content, indent=1, ensure_ascii=False, allow_nan=False))
