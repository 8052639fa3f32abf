"""The command of a live grasp: recognition, force, grip policy and haptic channel."""

import argparse
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hannes.commands.cli_output import add_force, add_json, print_json
from hannes.commands.cli_raw_log import write_what_came
from hannes.commands.cli_trust import add_trust
from hannes.core.errors import BadInput

if TYPE_CHECKING:
    from hannes.bench.live_run import LiveOrder, Moment
    from hannes.bench.reader import Link
    from hannes.recognition.model import Model

BAUD = 115_200  # of a tactor's port

EXAMPLES = {
    "live": """\
hannes live /dev/ttyUSB0 model.h5                        watch a hand that something else moves
hannes live /dev/ttyUSB0 model.h5 --close dynamometer    close it, under the grip policy
hannes live /dev/ttyUSB0 model.h5 --close dynamometer --newtons 20
hannes record empty-closure --port /dev/ttyUSB0 --out hand.h5    the empty hand, once
hannes live /dev/ttyUSB0 model.h5 --empty hand.h5 --close dynamometer
hannes live socket://127.0.0.1:4000 model.h5 --close my.toml --out grasp.h5 --haptics /dev/ttyACM0
`hannes dataset held` and `hannes train results/held.h5` make a model for held objects.""",
}


def add(command: Callable[..., argparse.ArgumentParser]) -> None:
    """Add the command; `command(name, call, description)` makes its parser."""
    from hannes.commands.cli_bench import add_empty, add_link

    live = command("live", _live, "recognise while the hand closes, and limit its grip")
    add_link(live, "port")
    add_trust(live)
    live.add_argument("model", help="a model made by `hannes train`")
    live.add_argument("--close", metavar="EXPERIMENT", help="close the hand by its command")
    live.add_argument(
        "--no-policy", action="store_true", help="send the command as it is, for comparison"
    )
    live.add_argument("--newtons", type=float, default=0.0, metavar="N",
                      help="hold with this force instead of a share of the command")  # fmt: skip
    add_empty(live)
    live.add_argument("--hand", metavar="HAND.toml", help="hand of the force observer (shipped)")
    live.add_argument("--no-observer", action="store_true",
                      help="force from the model alone, on a slow machine")  # fmt: skip
    live.add_argument("--haptics", metavar="PORT", help="send a tactor's commands to this port")
    live.add_argument(
        "--panel",
        action="store_true",
        help="in the browser, as `hannes panel` with this model",
    )
    live.add_argument("--seconds", type=float, default=0.0, help="how long (the experiment's)")
    live.add_argument("--out", metavar="FILE", help="a .h5 or .csv recording of it")
    add_force(live)
    add_json(live)


def _live(chosen: argparse.Namespace) -> None:
    from hannes.bench.record import RAW
    from hannes.commands.cli_bench import link
    from hannes.core.io.outputs import reserved
    from hannes.core.recording.marked import results_at
    from hannes.recognition import model_file

    if chosen.newtons < 0.0 or chosen.seconds < 0.0:
        raise BadInput("--newtons and --seconds: expected 0 or more")
    if chosen.newtons and not chosen.close:
        raise BadInput("--newtons holds while a command closes the hand: name one with --close")
    if chosen.newtons and chosen.no_policy:
        raise BadInput("--newtons is the policy's: leave out --no-policy")
    board = link(chosen)
    if chosen.panel:
        _in_browser(chosen, board)
        return
    model = model_file.read(chosen.model)
    if not chosen.out:
        import tempfile

        with tempfile.TemporaryDirectory() as folder:
            _followed(chosen, board, model, Path(folder) / f"live{RAW}")
        return
    out, raw = Path(chosen.out), Path(chosen.out + RAW)
    if raw.exists():
        raise BadInput(f"{raw}: is there already; a raw log is never written over")
    with reserved("live", results_at(out, "live"), [chosen.model], force=chosen.force):
        try:
            _followed(chosen, board, model, raw)
        finally:
            write_what_came(raw, out, "live")


def _in_browser(chosen: argparse.Namespace, board: "Link") -> None:
    from hannes.commands.cli_panel import BESIDE, serve

    given = (chosen.close, chosen.out, chosen.haptics, chosen.newtons, chosen.seconds, chosen.hand)
    if any((*given, chosen.no_observer, chosen.json)):
        raise BadInput(
            "--panel drives from the page: leave out all options but --no-policy, --empty and "
            "those of the port"
        )
    serve(board, BESIDE, chosen.model, policy=not chosen.no_policy, empty=chosen.empty)


def _followed(chosen: argparse.Namespace, board: "Link", model: "Model", raw: Path) -> None:
    from contextlib import ExitStack, closing

    from hannes.bench.live_display import Display, PlainLines
    from hannes.bench.live_run import live

    last: Moment | None = None
    with ExitStack() as stack:
        order = _order(chosen, model, stack)
        fancy = sys.stdout.isatty() and not chosen.json
        shown: Any = None
        if not chosen.json:
            shown = stack.enter_context(Display(board.port) if fancy else PlainLines())
        # Closed here: what ends the display is no exception within it, and must stop the board.
        for moment in stack.enter_context(closing(live(board, model, raw, order))):
            last = moment if moment.decision else last
            if shown is not None:
                shown.put(moment)
    if chosen.json:
        print_json(_summary(last) | {"hand_known": order.hand is not None})


def _order(chosen: argparse.Namespace, model: "Model", stack: Any) -> "LiveOrder":
    from hannes.bench.force_observer import ForceObserver
    from hannes.bench.grip_loop import GripPlan
    from hannes.bench.live_run import LiveOrder
    from hannes.commands.cli_bench import known_hand
    from hannes.simulation.experiment.load import load_experiment
    from hannes.simulation.hand.hand_file import load_hand

    variant = None
    if chosen.close:
        variants = load_experiment(chosen.close)
        if len(variants) > 1:
            raise BadInput(f"{chosen.close}: asks for {len(variants)} runs; close one at a time")
        (variant,) = variants
    hand = load_hand(chosen.hand) if chosen.hand else None
    plan = GripPlan(not chosen.no_policy, chosen.newtons)
    tactor = _tactor(chosen.haptics, stack) if chosen.haptics else None
    observer = None if chosen.no_observer else lambda: ForceObserver(hand)
    known = known_hand(chosen.empty, model)
    return LiveOrder(variant, plan, chosen.seconds, observer, tactor, _say, known)


def _tactor(name: str, stack: Any) -> Callable[..., None]:
    """What writes a tactor's commands to a second port; one that is gone ends the channel alone."""
    from hannes.bench.haptics import line
    from hannes.bench.port import LinkLost, Port

    port = stack.enter_context(Port(name, BAUD))
    gone: list[str] = []

    def send(command: Any) -> None:
        if gone:
            return
        try:
            port.write(line(command))
        except LinkLost as error:
            gone.append(str(error))
            _say(f"haptic channel: {error}; the grasp goes on without it")

    return send


def _summary(moment: "Moment | None") -> dict[str, Any]:
    from hannes.recognition.model import plain

    if moment is None or moment.decision is None:
        return {"decision": None}
    decision, force = moment.decision, moment.force
    return {
        "decision": decision.word,
        "rigid": decision.rigid,
        "firm": moment.firm,
        "stiffness": plain(decision.stiffness, "N/m"),
        "force": {"value": force.value, "low": force.low, "high": force.high, "unit": "N",
                  "residual": force.residual} if force else None,
    }  # fmt: skip


def _say(text: str) -> None:
    print(f"hannes: {text}", file=sys.stderr, flush=True)
