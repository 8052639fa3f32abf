"""The commands of the bench: a virtual board, recording from a board, the quality of a link."""

import argparse
import json
import sys
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext, suppress
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hannes.commands.cli_output import add_force, add_json, print_json
from hannes.commands.cli_port_number import port_number
from hannes.commands.cli_raw_log import say_what_is_left, write_what_came
from hannes.commands.cli_trust import add_trust
from hannes.core.errors import BadInput, ComputationFailed

if TYPE_CHECKING:
    from hannes.bench.dynamometer_live import LiveDynamometer
    from hannes.bench.reader import Link
    from hannes.core.recording.recording import Recording
    from hannes.recognition.model import Model

FINE = 1e-4  # relative tolerance, as of `simulate`: a diagnosis sees the errors of a coarser one
EXAMPLES = {
    "board": """\
hannes board dynamometer              a virtual hand on a pseudo-terminal; prints its name
hannes board my_board.toml --tcp 4000       on a socket of this machine
hannes board dynamometer --seconds 60

my_board.toml; all but the first line may be left out:
  experiment = "dynamometer"          # its hand, effects, object and noise
  [board]
  watchdog = "200 ms"
  current_limit = "6 A"
  [misbehaviour]
  lost = "0.1 %"                      # of packets; also repeated, damaged
  late = "5 ms"                       # longest delay of a packet
  cut = "3 s"                         # the cable is out from then on, for cut_for
  drift = "0.004 %"                   # of the board's clock""",
    "record": """\
hannes record void-closure --port /dev/ttyUSB0 --out void_01.h5
hannes record dynamometer --port socket://127.0.0.1:4000 --out grasp.h5
hannes record void-closure --port /dev/ttyACM0 --board text --baud 115200 --out void.csv
hannes record --recover void_01.h5.rawlog --out void_01.h5
hannes record --recover grasp.h5.rawlog --dynamometer vernier.csv --out grasp_force.h5""",
    "port": """\
hannes port
hannes port /dev/ttyUSB0
hannes port /dev/ttyUSB0 --seconds 30 --json""",
}


def add(command: Callable[..., argparse.ArgumentParser]) -> None:
    """Add the commands; `command(name, call, description)` makes the parser of one."""
    board = command("board", _board, "a virtual board: the hand's model behind a serial port")
    board.add_argument("specification", help="a shipped experiment, or a board's .toml file")
    board.add_argument(
        "--tcp", type=port_number, metavar="PORT", help="serve on this TCP port, not on a terminal"
    )
    board.add_argument("--seconds", type=float, default=0.0, help="run time [s] (0: no end)")
    add_trust(board)

    record = command("record", _record, "send an experiment's command to a board, and record")
    record.add_argument("experiment", nargs="?", help="a shipped experiment, or a .toml file")
    add_link(record, "--port")
    record.add_argument("--out", required=True, metavar="FILE", help="a .h5 or .csv file")
    record.add_argument("--reconnect", type=float, default=0.0, metavar="SECONDS",
                        help="wait so long for a lost link [s] (0, the default: end)")  # fmt: skip
    record.add_argument(
        "--recover", metavar="RAWLOG", help="make the recording from this raw log, without a board"
    )
    record.add_argument(
        "--dynamometer", metavar="FILE.csv|live",
        help="force of a Vernier dynamometer: its CSV export (with --recover), or live on USB",
    )  # fmt: skip
    add_force(record)
    add_json(record)
    add_trust(record)

    port = command("port", _port, "list serial ports, or measure the link to a board")
    add_link(port, "port")
    port.add_argument("--seconds", type=float, default=3.0, help="measuring time [s] (default 3)")
    add_json(port)


def add_link(parser: argparse.ArgumentParser, name: str) -> None:
    """Add what names a board: its port as the argument or option `name`, protocol, baud rate."""
    where = {} if name.startswith("-") else {"nargs": "?"}
    parser.add_argument(name, help="device, or socket://HOST:PORT", **where)  # type: ignore[arg-type]
    parser.add_argument(
        "--board", default="hannes", help="protocol: hannes (default), text, feetech"
    )
    parser.add_argument(
        "--baud", type=int, default=0, help="bits per second (default: the board's own)"
    )


def link(chosen: argparse.Namespace) -> "Link":
    """The link that the options of `add_link` ask for; BadInput where one is wrong."""
    from hannes.bench.adapters import adapter
    from hannes.bench.reader import Link

    if not chosen.port:
        raise BadInput("no port given; `hannes port` lists those there are")
    adapter(chosen.board)
    return Link(
        chosen.port, chosen.board, {}, chosen.baud, float(getattr(chosen, "reconnect", 0.0))
    )


def add_empty(parser: argparse.ArgumentParser) -> None:
    """Add the option that names a recording of the empty hand."""
    parser.add_argument(
        "--empty", metavar="FILE",
        help="a recording of `empty-closure` by this hand, which then is known (a middle hand)",
    )  # fmt: skip


def known_hand(path: str | None, model: "Model") -> Any:
    """Numbers of a recorded empty closure, None where there is none; BadInput where it is none."""
    if path is None:
        return None
    from hannes.core.recording.recording import Recording
    from hannes.recognition.known_hand import hand_numbers

    recording = Recording.read(path)
    try:
        return hand_numbers(recording, model)
    except BadInput as error:
        raise BadInput(f"{path}: {error}") from None


def _board(chosen: argparse.Namespace) -> None:
    from hannes.bench.board_file import read_board
    from hannes.bench.virtual_board import Socket, Terminal, VirtualBoard
    from hannes.bench.virtual_hand import VirtualHand

    given = read_board(chosen.specification)
    variant = given.variant

    def machine() -> VirtualHand:
        return VirtualHand(variant.hand, variant.experiment, FINE)

    machine().step(None)  # compiled before anybody connects
    far = Terminal() if chosen.tcp is None else Socket(chosen.tcp)
    print(far.address, flush=True)
    board = VirtualBoard(machine, far, given.settings, given.how)
    ticks = round(chosen.seconds * given.settings.rate)
    try:
        with suppress(KeyboardInterrupt):  # its usual end
            board.run(lambda: bool(ticks) and board.ticks >= ticks)
        _say("the board has ended")
    finally:
        far.close()


def _record(chosen: argparse.Namespace) -> None:
    from hannes.bench.record import RAW
    from hannes.core.io.outputs import reserved
    from hannes.core.recording.marked import results_at

    out, raw = Path(chosen.out), Path(chosen.out + RAW)
    reads = [chosen.recover] if chosen.recover else []
    if chosen.dynamometer and chosen.dynamometer != "live":
        if not chosen.recover:
            raise BadInput(
                f"--dynamometer {chosen.dynamometer}: its export comes after the recording; record "
                f"first, then --recover {raw} with it"
            )
        reads.append(chosen.dynamometer)
    writes = results_at(out, "record")
    if chosen.dynamometer == "live":
        writes.append(_force_file(raw))
    with reserved("record", writes, reads, force=chosen.force):
        _recorded(chosen, out, raw)


def _recorded(chosen: argparse.Namespace, out: Path, raw: Path) -> None:
    from hannes.bench.dynamometer import merged, read_vernier
    from hannes.bench.record import record, recover
    from hannes.core.recording.marked import write_marked

    if chosen.recover:
        if chosen.dynamometer == "live":
            raise BadInput("--dynamometer live: nothing is live in a raw log; give its CSV export")
        made = recover(chosen.recover, _say)
        if chosen.dynamometer:
            made = merged(made, read_vernier(chosen.dynamometer))
            shift = json.loads(made.conversion)["dynamometer"]["shift_s"]
            _say(f"the dynamometer's force is merged, its clock shifted by {shift:+.3f} s")
        write_marked(made, out, "record")
        _said(chosen, {"out": str(out), "samples": made.time.size, "raw": chosen.recover})
        return
    if not chosen.experiment:
        raise BadInput("no experiment given; `hannes experiments` lists them")
    if raw.exists():
        raise BadInput(f"{raw}: is there already; a raw log is never written over")
    board = link(chosen)
    with _dynamometer(chosen) as force:
        try:
            done = record(chosen.experiment, board, raw, progress=_say)
        except BadInput:
            say_what_is_left(raw, out)
            raise
        except BaseException:
            write_what_came(raw, out, "record", lambda made: _forced(made, force, raw, out))
            raise
    made, why = _with_force(done.recording, force, raw, out)
    write_marked(made, out, "record")
    said = {"out": str(out), "raw": str(raw), "samples": made.time.size}
    _said(chosen, said | {"stop_seen": done.stopped})
    if why:
        raise ComputationFailed(why)


def _with_force(
    made: "Recording", live: "LiveDynamometer | None", raw: Path, out: Path
) -> tuple["Recording", str]:
    """The recording with the dynamometer's force; without it where they do not fit, and why not.

    The force is kept then, in a file of its own.
    """
    from hannes.bench.dynamometer import merged, write_vernier

    if live is None:
        return made, ""
    try:
        log = live.log()
    except BadInput as error:
        return made, f"{error}; {out} has no force"
    try:
        return merged(made, log), ""
    except BadInput as error:
        write_vernier(log, _force_file(raw))
        return made, (
            f"{error}; {out} has no force, which is kept: once it is mended, `hannes record "
            f"--recover {raw} --dynamometer {_force_file(raw)} --out FILE`"
        )


def _forced(made: "Recording", live: "LiveDynamometer | None", raw: Path, out: Path) -> "Recording":
    """As `_with_force`, where something else has failed already."""
    made, why = _with_force(made, live, raw, out)
    if why:
        _say(why)
    return made


def _force_file(raw: Path) -> Path:
    """Where a live dynamometer's force is kept when it fits no recording."""
    return Path(f"{raw}.force.csv")


def _dynamometer(chosen: argparse.Namespace) -> "AbstractContextManager[LiveDynamometer | None]":
    """The live dynamometer that is asked for, or nothing."""
    from hannes.bench.dynamometer_live import LiveDynamometer

    return LiveDynamometer() if chosen.dynamometer else nullcontext()


def _said(chosen: argparse.Namespace, report: dict[str, Any]) -> None:
    if chosen.json:
        print_json(report)
        return
    print(f"wrote {report['out']}: {report['samples']} samples (raw bytes: {report['raw']})")
    print(f"next: hannes check {report['out']}")


def _port(chosen: argparse.Namespace) -> None:
    from hannes.bench.port import listed
    from hannes.bench.port_report import examine

    if not chosen.port:
        found = listed()
        if chosen.json:
            print_json([{"port": name, "what": what} for name, what in found])
        else:
            print("\n".join(f"{n}  {w}" for n, w in found) or "no serial port on this machine")
        return
    report = examine(link(chosen), chosen.seconds)
    if chosen.json:
        print_json(asdict(report) | {"advice": report.advice()})
        return
    print(f"{chosen.port}: {report.about.firmware}, {report.about.rate:g} Hz")
    if report.round_trip:
        middle, high, longest = (1e3 * each for each in report.round_trip)
        print(f"  round trip  {middle:.2f} ms (99 %: {high:.2f}, longest {longest:.2f})")
    else:
        print("  round trip  not measured: this kind of board says no status")
    print(f"  frames      {report.rows} samples, {report.lost} lost, {report.damaged} damaged")
    print(f"  clock       {1e6 * report.drift:+.1f} ppm against this machine's")
    for line in [*report.notes, *report.advice()]:
        print(f"  {line}")


def _say(text: str) -> None:
    print(f"hannes: {text}", file=sys.stderr)
