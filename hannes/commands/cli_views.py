"""The command that shows recordings: a hand in motion in one page."""

import argparse
from collections.abc import Callable

from hannes.commands.cli_output import add_json, print_json

EXAMPLES = {
    "view": """\
hannes view results/dynamometer/recording.h5
hannes view void_01.csv --hand results/closure/hand.toml     measured, and with what was found
hannes view before.h5 after.h5 --out results/both.html       the second as a ghost over the first
hannes view grasp.h5 --still 0.64                            an SVG and a PNG of one moment""",
}


def add(command: Callable[..., argparse.ArgumentParser]) -> None:
    """Add the command; `command(name, call, description)` makes its parser."""
    view = command("view", _view, "show one recording, or two, as a hand in motion")
    view.add_argument("recording", nargs="+", help="one or two recordings of the hand")
    view.add_argument(
        "--hand", action="append", default=[], metavar="HAND.toml",
        help="the hand that draws them, once for all or once for each (default: their own)",
    )  # fmt: skip
    view.add_argument(
        "--out", default="results/view.html", metavar="FILE", help="page (results/view.html)"
    )
    view.add_argument(
        "--still", action="append", default=[], type=float, metavar="TIME",
        help="also write an SVG and a PNG of this moment [s]; may be given again",
    )  # fmt: skip
    add_json(view)


def _view(chosen: argparse.Namespace) -> None:
    from hannes.commands.view import view

    made = view(chosen.recording, chosen.out, hands=chosen.hand, stills=chosen.still)
    if chosen.json:
        print_json(made)
        return
    for each in made["recordings"]:
        print(f"{each['name']}: {each['note']}")
    for path in made["stills"]:
        print(f"wrote {path}")
    print(f"open {made['out']} ({made['bytes'] / 1000.0:.0f} kB)")
