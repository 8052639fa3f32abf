"""The commands that hand recordings on: to the eye, to other programs; and completion."""

import argparse
from collections.abc import Callable, Mapping, Sequence

from hannes.commands.cli_output import add_force, add_json, print_json
from hannes.commands.cli_trust import add_trust

EXAMPLES = {
    "view": """\
hannes view results/dynamometer/recording.h5
hannes view void_01.csv --hand results/closure/hand.toml     measured, and with what was found
hannes view before.h5 after.h5 --out results/both.html       the second as a ghost over the first
hannes view grasp.csv --experiment dynamometer               what was done, where no file says it
hannes view grasp.h5 --still 0.64                            an SVG and a PNG of one moment""",
    "export": """\
hannes export void_01.h5 --out void_01.mat            MATLAB
hannes export results/dynamometer/recording.h5 --out grasp.mcap     Foxglove, ROS
hannes export void_01.csv --out void_01.h5""",
    "fmu": """\
hannes fmu dynamometer --out hand.fmu
hannes fmu my.toml --out my.fmu                       for any tool that co-simulates""",
    "completion": """\
hannes completion bash > ~/.local/share/bash-completion/completions/hannes
hannes completion zsh > ~/.zfunc/_hannes              a folder of $fpath""",
}
FORMATS = {".mat": "to_mat", ".mcap": "to_mcap"}


def add(command: Callable[..., argparse.ArgumentParser], whole: argparse.ArgumentParser) -> None:
    """Add the commands; `command(name, call, description)` makes the parser of one of `whole`."""
    view = command("view", _view, "show one recording, or two, as a hand in motion")
    view.add_argument("recording", nargs="+", help="one or two recordings of the hand")
    view.add_argument(
        "--hand", action="append", default=[], metavar="HAND.toml",
        help="the hand that draws them, once for all or once for each (default: their own)",
    )  # fmt: skip
    view.add_argument(
        "--experiment", action="append", default=[], metavar="NAME",
        help="what was done: a shipped name or a .toml, once for all or once for each "
             "(default: as the recording says)",
    )  # fmt: skip
    view.add_argument(
        "--out", default="results/view.html", metavar="FILE", help="page (results/view.html)"
    )
    view.add_argument(
        "--still", action="append", default=[], type=float, metavar="TIME",
        help="also write an SVG and a PNG of this moment [s]; may be given again",
    )  # fmt: skip
    add_trust(view)
    add_force(view)
    add_json(view)

    export = command("export", _export, "write a recording in another program's format")
    export.add_argument("recording", help="a recording: .csv, .csv.gz, .h5, .hdf5")
    export.add_argument(
        "--out", required=True, metavar="FILE", help=".mat, .mcap, .csv, .csv.gz, .h5 or .hdf5"
    )
    add_force(export)

    fmu = command("fmu", _fmu, "write a hand as an FMU for co-simulation")
    fmu.add_argument("experiment", help="a shipped experiment's name, or a .toml file")
    fmu.add_argument(
        "--out", default="results/hand.fmu", metavar="FILE", help="the FMU (results/hand.fmu)"
    )
    add_trust(fmu)
    add_force(fmu)

    completion = command("completion", _completion, "print what completes commands in a shell")
    completion.add_argument("shell", choices=("bash", "zsh", "tcsh"), help="bash, zsh or tcsh")
    completion.set_defaults(whole=whole)


def _export(chosen: argparse.Namespace) -> None:
    from pathlib import Path

    from hannes.core.io.outputs import reserved
    from hannes.core.recording.marked import results_at, write_marked
    from hannes.core.recording.recording import Recording

    other = FORMATS.get(Path(chosen.out).suffix.lower())
    targets = [chosen.out] if other else results_at(chosen.out, "export")
    with reserved("export", targets, [chosen.recording], force=chosen.force):
        recording = Recording.read(chosen.recording)
        if other:
            getattr(recording, other)(chosen.out)
        else:
            write_marked(recording, chosen.out, "export")
    print(f"wrote {chosen.out}")


def _fmu(chosen: argparse.Namespace) -> None:
    from hannes.commands.fmu import fmu

    made = fmu(chosen.experiment, chosen.out, force=chosen.force)
    print(f"wrote {made['out']}; step in multiples of {1e3 * made['step']:g} ms")


def _completion(chosen: argparse.Namespace) -> None:
    import shtab

    from hannes.campaigns.campaign_file import shipped_campaigns
    from hannes.simulation import catalogue
    from hannes.simulation.experiment import shipped

    known = {
        "experiment": shipped.names(),
        "campaign": list(shipped_campaigns()),
        "effect": sorted(catalogue.effects()),
    }
    for commands in chosen.whole._actions:
        if isinstance(commands, argparse._SubParsersAction):
            for command in commands.choices.values():
                for action in command._actions:
                    _complete(action, known)
    print(shtab.complete(chosen.whole, chosen.shell))


def _complete(action: argparse.Action, known: Mapping[str, Sequence[str]]) -> None:
    """Declare to shtab what an argument is: a folder, a name that ships or a file, or a file."""
    import shtab

    if action.dest in known:
        action.choices = [*known[action.dest], shtab.Choice("file")]
    elif action.metavar == "FOLDER":
        action.complete = shtab.DIRECTORY  # type: ignore[attr-defined]
    elif action.dest in ("file", "recording", "hand", "mapping", "out"):
        action.complete = shtab.FILE  # type: ignore[attr-defined]


def _view(chosen: argparse.Namespace) -> None:
    from hannes.commands.view import view

    made = view(
        chosen.recording, chosen.out, hands=chosen.hand, experiments=chosen.experiment,
        stills=chosen.still, force=chosen.force,
    )  # fmt: skip
    if chosen.json:
        print_json(made)
        return
    for each in made["recordings"]:
        print(f"{each['name']}: {each['note']}")
    for path in made["stills"]:
        print(f"wrote {path}")
    print(f"open {made['out']} ({made['bytes'] / 1000.0:.0f} kB)")
