"""The command `hannes`: parses, calls the library, prints; libraries load where they are used."""

import argparse
import json
import sys
import textwrap
from collections.abc import Callable, Sequence
from functools import cache, partial
from typing import Any, NoReturn

from hannes.commands import (
    cli_bench,
    cli_compare,
    cli_firmware,
    cli_learning,
    cli_live,
    cli_panel,
    cli_recordings,
    cli_trust,
    cli_views,
)
from hannes.commands.cli_examples import EXAMPLES
from hannes.commands.cli_output import add_describe, add_force, add_json, print_json
from hannes.commands.cli_trust import add_trust
from hannes.commands.edge import guarded
from hannes.core.errors import BadInput, Interrupted, nearest
from hannes.core.trust.consent import Consent, consenting
from hannes.core.version import VERSION
from hannes.simulation.compiler.kernel_error import blamed

DESCRIPTION = "A model of the Hannes prosthetic hand that says what it is missing."


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
    """Run one command; return its exit status.

    0 done, 2 bad input, 3 computation failed, 70 a fault that nobody foresaw, 130 interrupted.
    """
    given = list(sys.argv[1:] if arguments is None else arguments)
    return guarded(lambda: _run(given), given)


def _run(arguments: Sequence[str]) -> None:
    parser = make_parser()
    chosen = parser.parse_args(arguments)
    if chosen.command is None:
        parser.print_help()
        return
    try:
        with consenting(Consent.GIVEN if getattr(chosen, "trust", False) else Consent.ASK):
            chosen.call(chosen)
    except Exception as error:
        if (fault := blamed(error)) is None:
            raise
        raise fault from None


@cache
def make_parser() -> _Parser:
    """The parser of all commands; made once a process, for tests and notebooks call many."""
    parser = _Parser(prog="hannes", description=DESCRIPTION, **_with_examples(""))
    parser.add_argument("--version", action="version", version=f"hannes {VERSION}")
    commands = parser.add_subparsers(dest="command", metavar="COMMAND", parser_class=_Parser)
    _add_models(commands)
    _add_results(commands)
    cli_recordings.add(partial(_command, commands))
    cli_compare.add(partial(_command, commands))
    cli_learning.add(partial(_command, commands))
    cli_bench.add(partial(_command, commands))
    cli_live.add(partial(_command, commands))
    cli_firmware.add(partial(_command, commands))
    cli_panel.add(partial(_command, commands))
    cli_views.add(partial(_command, commands), parser)
    cli_trust.add(partial(_command, commands))
    return parser


def _add_models(commands: Any) -> None:
    run = _command(commands, "run", _run_experiment, "simulate an experiment and write its results")
    run.add_argument("experiment", help="a shipped experiment's name, or a .toml file")
    _add_output(run, "results/<experiment>")
    run.add_argument("--method", default="Rodas", help="solver: Rodas (default) or one of scipy's")
    run.add_argument("--rtol", type=float, default=1e-4, help="relative tolerance (default 1e-4)")
    add_trust(run)

    _command(commands, "experiments", _experiments, "list the shipped experiments")

    effects = _command(commands, "effects", _effects, "list the effects, or describe one")
    effects.add_argument("effect", nargs="?", help="a name, or file.py:EFFECT of your own")
    effects.add_argument(
        "--plant",
        metavar="PLANT",
        help="machine that has the effects: hand (default), axis, finger, module:object",
    )

    hand = _command(commands, "hand", _hand, "show a hand: parts, equations, effects, values")
    hand.add_argument(
        "hand",
        nargs="?",
        default="hannes",
        help="a hand.toml of any machine (default: the shipped hand)",
    )
    hand.add_argument("--equations", action="store_true", help="print the assembled equations")
    hand.add_argument("--values", action="store_true", help="print every value with its source")
    hand.add_argument("--mjcf", action="store_true", help="print a MuJoCo model of its mechanics")
    hand.add_argument("--schematic", action="store_true", help="print a drawing of it, as SVG")
    add_trust(hand)


def _add_results(commands: Any) -> None:
    reproduce = _command(commands, "reproduce", _reproduce, "the paper's results beside ours")
    _add_output(reproduce, "results/reproduce")
    reproduce.add_argument(
        "--slack", metavar="FOLDER", help="results of a diagnosis of closures with hidden slack"
    )
    reproduce.add_argument(
        "--taut", metavar="FOLDER", help="results of a diagnosis of the same closures without it"
    )
    reproduce.add_argument(
        "--recognition", metavar="FOLDER", help="results of an evaluation of the ten objects"
    )
    reproduce.add_argument(
        "--coming", nargs="+", choices=("emps", "slack", "recognition"), default=(), metavar="PART",
        help="of emps, slack, recognition: the page says that it is still being computed",
    )  # fmt: skip

    calibrate = _command(commands, "calibrate", _calibrate, "fit parameters, with intervals")
    calibrate.add_argument("campaign", help="a campaign's .toml file")
    _add_output(calibrate, "as the campaign says")
    add_trust(calibrate)

    diagnose = _command(commands, "diagnose", _diagnose, "say what a model is missing")
    diagnose.add_argument("campaign", help="a campaign's .toml file")
    _add_output(diagnose, "as the campaign says")
    add_describe(diagnose)
    add_trust(diagnose)


def _command(
    commands: Any, name: str, call: Callable[[argparse.Namespace], None], description: str
) -> _Parser:
    texts = {"help": description, "description": description, **_with_examples(name)}
    parser = commands.add_parser(name, **texts)
    parser.set_defaults(call=call)
    return parser


def _with_examples(name: str) -> dict[str, Any]:
    lines = "\n".join(f"  {line}" for line in EXAMPLES[name].splitlines())
    return {
        "epilog": f"examples:\n{lines}",
        "formatter_class": argparse.RawDescriptionHelpFormatter,
        "allow_abbrev": False,
    }


def _add_output(parser: _Parser, default: str) -> None:
    parser.add_argument("--out", metavar="FOLDER", help=f"folder of the results ({default})")
    add_force(parser)
    add_json(parser)


def _run_experiment(chosen: argparse.Namespace) -> None:
    from hannes.commands.run import run

    how = {"method": chosen.method, "rtol": chosen.rtol, "force": chosen.force}
    summary = run(chosen.experiment, chosen.out, **how)
    if chosen.json:
        print_json(summary)
    else:
        print(_summary_text(summary))


def _summary_text(summary: dict[str, Any]) -> str:
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
        question = shipped.question(shipped.find(name))
        print(textwrap.fill(question, 78, initial_indent="  ", subsequent_indent="  "))


def _effects(chosen: argparse.Namespace) -> None:
    from hannes.commands.effects import described, listed

    name, plant = chosen.effect, chosen.plant
    print(described(name, plant) if name else listed(plant))


def _hand(chosen: argparse.Namespace) -> None:
    from hannes.plants.plant_file import load_model, own_python_described
    from hannes.simulation.hand.description import equations_of, plant_described, value_table
    from hannes.simulation.hand.hand import Hand

    if not chosen.trust and (text := own_python_described(chosen.hand)):
        if chosen.equations or chosen.values:
            raise BadInput(
                f"{chosen.hand} names Python of its own, which a look does not run: look at it, "
                "then add --trust"
            )
        print(text)
        return
    model = load_model(chosen.hand, trust=chosen.trust)
    if chosen.equations:
        print(equations_of(model))
    elif chosen.values:
        print(value_table(model))
    elif chosen.mjcf or chosen.schematic:
        print(_exported(model, chosen.mjcf), end="")
    else:
        print(str(model) if isinstance(model, Hand) else plant_described(model, model.name))


def _exported(model: Any, mujoco: bool) -> str:
    """A hand as MuJoCo's model or as a drawing; BadInput for another plant."""
    from hannes.report.schematic import schematic
    from hannes.simulation.hand.hand import Hand
    from hannes.simulation.hand.mjcf import mjcf

    if not isinstance(model, Hand):
        raise BadInput(f'the plant "{model.name}" is no hand: only a hand is drawn or exported')
    return mjcf(model) if mujoco else schematic(model)


def _reproduce(chosen: argparse.Namespace) -> None:
    from hannes.commands.reproduce import reproduce

    out = chosen.out or "results/reproduce"
    given = {"slack": chosen.slack, "taut": chosen.taut, "recognition": chosen.recognition}
    found = reproduce(out, coming=chosen.coming, force=chosen.force, **given)
    if chosen.json:
        print_json(found)
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
    from hannes.commands.next_step import after_calibrate

    campaign = read_campaign(chosen.campaign)
    out = chosen.out or campaign.out
    result = calibrate(campaign, out=out, force=chosen.force, progress=True)
    if chosen.json:
        print_json(result.plain())
    else:
        print(f"{result.summary()}\nopen {out}/report.html")
        print(after_calibrate(chosen.campaign, out, result))
    if result.found.interrupted:
        raise Interrupted(f"interrupted; the best so far stands in {out}")


def _diagnose(chosen: argparse.Namespace) -> None:
    from hannes.campaigns.campaign_file import read_campaign
    from hannes.commands.diagnose import diagnose

    campaign = read_campaign(chosen.campaign)
    out = chosen.out or campaign.out
    asked = {"force": chosen.force, "describe": chosen.describe}
    verdict = diagnose(campaign, out=out, progress=True, **asked).verdict
    if chosen.json:
        return print_json(json.loads(verdict.json()))
    print(f"{verdict.summary()}\nopen {out}/report.html")
