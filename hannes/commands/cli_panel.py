"""The command of the panel: a hand on a port, in a browser on the same machine."""

import argparse
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from hannes.commands.cli_port_number import port_number
from hannes.commands.cli_raw_log import say_what_is_left
from hannes.commands.cli_trust import add_trust
from hannes.core.errors import BadInput

if TYPE_CHECKING:
    from hannes.bench.reader import Link

BESIDE = "void-closure"

EXAMPLES = {
    "panel": """\
hannes panel /dev/ttyUSB0
hannes panel /dev/ttyUSB0 --model results/large-model.h5
hannes panel socket://127.0.0.1:4000 --beside dynamometer --raw session.rawlog""",
}


def add(command: Callable[..., argparse.ArgumentParser]) -> None:
    """Add the command; `command(name, call, description)` makes its parser."""
    from hannes.commands.cli_bench import add_empty, add_link

    panel = command("panel", _panel, "drive a hand on a port from a page in the browser")
    add_link(panel, "port")
    add_trust(panel)
    add_empty(panel)
    panel.add_argument("--model", metavar="MODEL.h5", help="recognise with it (`hannes train`)")
    panel.add_argument(
        "--no-policy",
        action="store_true",
        help="begin without a limit on the grip; the page can switch it",
    )
    panel.add_argument(
        "--beside", default=BESIDE, metavar="EXPERIMENT",
        help="whose hand and object step beside the measured ones (void-closure)",
    )  # fmt: skip
    panel.add_argument(
        "--http", type=port_number, default=0, metavar="PORT", help="port of the page (any)"
    )
    panel.add_argument(
        "--raw", metavar="FILE", help="keep all bytes, for `hannes record --recover`"
    )


def _panel(chosen: argparse.Namespace) -> None:
    from hannes.commands.cli_bench import link

    raw = Path(chosen.raw) if chosen.raw else None
    policy = not chosen.no_policy
    serve(link(chosen), chosen.beside, chosen.model, chosen.http, raw, policy, chosen.empty)


def serve(
    board: "Link", beside: str, model: str | None, http: int = 0, raw: Path | None = None,
    policy: bool = True, empty: str | None = None,
) -> None:  # fmt: skip
    """Serve the page of a board until it is closed; `beside` names the model that steps along.

    empty: path of a recording of the empty hand. Raises BadInput where it is given without a model.
    """
    from hannes.bench.board_file import read_board
    from hannes.bench.panel.run import Panel, run_panel
    from hannes.commands.cli_bench import known_hand
    from hannes.core.io.outputs import reserved
    from hannes.recognition import model_file

    if empty and not model:
        raise BadInput("--empty is for a model that recognises: name one with --model")
    known = model_file.read(model) if model else None
    hand = known_hand(empty, known) if known else None
    panel = Panel(board, read_board(beside).variant, known, http, raw, policy, hand)
    if raw and raw.exists():
        raise BadInput(f"{raw}: is there already; a raw log is never written over")
    with reserved("panel", [raw] if raw else []):
        try:
            run_panel(panel, lambda text: print(f"hannes: {text}", file=sys.stderr, flush=True))
        finally:
            if raw:
                say_what_is_left(raw, "FILE")
