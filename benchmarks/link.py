"""The link to a board: damaged frames, a recorder that is killed, a cable that is pulled, latency.

damaged   frames of eight kinds of damage: none accepted that differs, none twice, and how soon
          frames are read again
killed    the recorder's process killed (kill -9) at random times: what of the frames older than
          20 ms is in the raw log
cable     the cable out at random times: how soon the board stops, and what the recording has
rate      ten minutes a row at 1 kHz, idle and beside four busy processes, with and without
          real-time priority of reader and deciding process: lost frames, time from a sample to its
          decision, clock map, processor share of both, and the share of all processors that the
          host of a virtual machine gave to others, which no priority here can help. The board
          stands for hardware, so its process has real-time priority in every row that allows it.
          Rows that are done are kept in results/link-rows.jsonl: start it again, and it goes on
          with those that are missing
"""

import gc
import hashlib
import json
import multiprocessing
import os
import random
import resource
import signal
import tempfile
import threading
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from tqdm import tqdm

from benchmarks.harness import Row, main, must_show, processor
from hannes.bench.board_logic import BoardLogic, Machine, Settings
from hannes.bench.events import Row as Sample
from hannes.bench.finish import gaps, read_rows
from hannes.bench.frames import Frame, Splitter, encode
from hannes.bench.messages import Channel, State
from hannes.bench.misbehaviour import Misbehaviour
from hannes.bench.reader import Link, Reader, raise_priority
from hannes.bench.sequence import Received
from hannes.bench.session import session
from hannes.bench.virtual_board import Terminal, VirtualBoard
from hannes.core.errors import ComputationFailed

PARTS = ("damaged", "killed", "cable", "rate")
KIND, LENGTH = 34, 14
KINDS = ("bit", "byte", "missing", "extra", "torn tail", "torn head", "repeat", "noise")
DRIFT = 40e-6
MISSED = "missed: this machine allows no real-time priority"
KEPT = Path("results/link-rows.jsonl")
LEAST_KEPT = 1.0  # minutes of a row that is worth keeping


class Shaft:
    """A machine that costs nothing: the link is what is measured."""

    channels = (
        Channel(0, "reference", "rad", "i", 1e-6),
        Channel(1, "position", "rad", "i", 1e-6),
        Channel(2, "current", "A", "i", 1e-5),
    )

    def __init__(self) -> None:
        self.position = 0.0

    def step(self, reference: float | None) -> dict[str, float]:
        """Follow with a lag."""
        wanted = self.position if reference is None else reference
        current = wanted - self.position
        self.position += 0.05 * current
        return {"reference": wanted, "position": self.position, "current": current}


# ---- damaged frames ------------------------------------------------------------------------------


def wear(packet: bytes, kind: str, chance: random.Random) -> bytes:
    """Damage one packet, its closing zero included."""
    at = chance.randrange(len(packet))
    if kind == "bit":
        return packet[:at] + bytes([packet[at] ^ 1 << chance.randrange(8)]) + packet[at + 1 :]
    if kind == "byte":
        return packet[:at] + bytes([chance.randrange(256)]) + packet[at + 1 :]
    if kind == "missing":
        return packet[:at] + packet[at + 1 :]
    if kind == "extra":
        return packet[:at] + bytes([chance.randrange(256)]) + packet[at:]
    if kind == "torn tail":
        return packet[:at]
    if kind == "torn head":
        return packet[at:]
    if kind == "repeat":
        return packet * 2
    return packet[:at] + chance.randbytes(chance.randrange(1, 60)) + packet[at:]


def damaged(count: int) -> tuple[list[Row], list[Row]]:
    """Every third frame is damaged; the others show how soon the stream is read again."""
    rows = []
    for number, kind in enumerate(tqdm(KINDS, "damaged", leave=False)):
        rows.append({"part": "damaged", "what": kind, **_worn(kind, count // len(KINDS), number)})
    wrong = sum(row["wrong"] for row in rows)
    twice = sum(row["twice"] for row in rows)
    longest = max(row["until read again"] for row in rows)
    return rows, [
        must_show("damaged frames accepted that differ", wrong, 0, wrong == 0),
        must_show("damaged frames accepted twice", twice, 0, twice == 0),
        must_show("frames until the stream is read again, most", longest, 2, longest <= 2),
    ]


def _worn(kind: str, count: int, seed: int) -> Row:
    chance, splitter, received = random.Random(seed), Splitter({KIND: LENGTH}), Received()
    sent: dict[int, Frame] = {}
    accepted, wrong, twice, waiting, longest = set(), 0, 0, 0, 0
    for number in range(3 * count):
        frame = Frame(KIND, number, 1000 * number, chance.randbytes(LENGTH))
        sent[number] = frame
        sent.pop(number - 100, None)
        packet = encode(frame)
        hit = number % 3 == 0
        found = splitter.feed(wear(packet, kind, chance) if hit else packet)
        fresh = [each for each in found if received.accept(each.sequence)]
        wrong += sum(each != sent.get(each.sequence) for each in fresh)
        twice += sum(each.sequence in accepted for each in fresh)
        accepted.update(each.sequence for each in fresh)
        accepted.discard(number - 100)
        waiting = 0 if any(each.sequence == number for each in fresh) else waiting + 1
        longest = max(longest, waiting)
    return {"frames": count, "wrong": wrong, "twice": twice, "until read again": longest}


# ---- a board in a process of its own ------------------------------------------------------------


def _board(pipe: "multiprocessing.connection.Connection", how: Misbehaviour) -> None:
    """Run a board on a pseudo-terminal until a stop; sends its name, then when it stopped."""
    far = Terminal()
    pipe.send(far.address)
    raise_priority()
    board = VirtualBoard(Shaft, far, Settings(), how, on_time=True)
    board.run(pipe.poll)
    far.close()


class BoardProcess:
    """A virtual board beside this process."""

    def __init__(self, how: Misbehaviour | None = None) -> None:
        context = multiprocessing.get_context("spawn")
        self._pipe, far = context.Pipe()
        self._process = context.Process(target=_board, args=(far, how or Misbehaviour()))
        self._process.start()
        self.address: str = self._pipe.recv()

    def __enter__(self) -> "BoardProcess":
        return self

    def __exit__(self, *_: object) -> None:
        self._pipe.send("end")
        self._process.join()


# ---- a recorder that is killed -------------------------------------------------------------------


def killed(count: int) -> tuple[list[Row], list[Row]]:
    """Kill the reader's process at a random moment; compare its log with what the board sent."""
    lost = []
    chance = random.Random(1)
    with tempfile.TemporaryDirectory() as folder, BoardProcess() as board:
        for k in tqdm(range(count), "killed", leave=False):
            log = Path(folder) / f"{k}.rawlog"
            reader = Reader(Link(board.address), log)
            reader.send(Link(board.address).adapter().ask())
            time.sleep(0.3 + 0.5 * chance.random())
            dead = time.monotonic()  # before it is: this process may lose its turn after the kill
            os.kill(reader.pid, signal.SIGKILL)
            reader.close()
            rows = read_rows(log)
            newest = float(rows.clock().host(rows.board)[-1])
            inside = sum(round((b - a) * 1000) - 1 for a, b in gaps(rows.board, 1e-3))
            late = max(dead - newest - 0.020, 0.0)
            lost.append(inside + int(late * 1000))
    complete = sum(each == 0 for each in lost)
    row = {"part": "killed", "what": "kill -9", "frames": count, "wrong": count - complete}
    name = "recorders killed of which all frames older than 20 ms were recovered"
    return [row], [must_show(name, complete, count, complete == count)]


# ---- a cable that is pulled ----------------------------------------------------------------------


def cable(count: int) -> tuple[list[Row], list[Row]]:
    """Pull the cable at a random moment of a profile; the board must stop by its watchdog."""
    chance, late, marked = random.Random(2), [], 0
    for _ in tqdm(range(count), "cable", leave=False):
        cut = 0.15 + 0.6 * chance.random()
        stopped, has_gap = _pulled(cut)
        late.append(stopped - Settings().watchdog * 1e-6)
        marked += has_gap
    allowed = 1.0 / Settings().rate
    good = sum(each <= allowed + 1e-9 for each in late)
    row = {"part": "cable", "what": "cable out", "frames": count, "wrong": count - good}
    return [row], [
        must_show(
            "cables pulled: board stopped within watchdog and a tick", good, count, good == count
        ),
        must_show(
            "cables pulled: the recording ends or has its gap", marked, count, marked == count
        ),
    ]


class _Watched(BoardLogic):
    """Notes how long after the last word of the host the board stopped."""

    def __init__(self, machine: Machine, settings: Settings) -> None:
        super().__init__(machine, settings)
        self.stopped_after: float | None = None

    def _watch(self) -> None:
        before = self.state
        super()._watch()
        if self.state is State.WATCHDOG and before is not State.WATCHDOG:
            self.stopped_after = (self.time - self._heard) * 1e-6


def _pulled(cut: float) -> tuple[float, bool]:
    """Time from the last word of the host to the stop [s]; whether the recording shows the cut."""
    far, over = Terminal(), threading.Event()
    board = VirtualBoard(Shaft, far, Settings(), Misbehaviour())
    board.logic = watched = _Watched(Shaft(), Settings())
    thread = threading.Thread(target=board.run, args=(over.is_set,))
    thread.start()
    with tempfile.TemporaryDirectory() as folder:
        log = Path(folder) / "run.rawlog"
        try:
            with session(Link(far.address), log) as talk:
                talk.hello()
                talk.profile([(0.0, 0.0), (2.0, 5.0)])
                out = board.moment + cut
                board.cable.how = Misbehaviour(cut=out)
                talk.wait(lambda: watched.stopped_after is not None, 3.0)
        except ComputationFailed:
            pass
        rows = read_rows(log)
    over.set()
    thread.join()
    far.close()
    return watched.stopped_after or np.inf, bool(rows.board[-1] < out + 0.01)


# ---- minutes at 1 kHz ----------------------------------------------------------------------------


def _busy() -> None:
    while True:
        sum(range(10_000))


def rate(minutes: float) -> tuple[list[Row], list[Row]]:
    """A row for each load and priority; those that are kept are not measured again."""
    rows = [_kept(minutes, load, real_time) for load in (0, 4) for real_time in (False, True)]
    return rows, [bound for row in rows for bound in _bounds(row)]


def _kept(minutes: float, load: int, real_time: bool) -> Row:
    """A row of an earlier run of the same code on the same machine, or measured now and kept."""
    digest = hashlib.sha256(b"".join(each.read_bytes() for each in sorted(_sources())))
    key = f"{minutes} min, {load}, {real_time}, {processor()}, {digest.hexdigest()[:16]}"
    if KEPT.exists():
        for line in KEPT.read_text().splitlines():
            if (known := json.loads(line))["key"] == key:
                return dict(known["row"])
    row = _row(minutes, load, real_time)
    if minutes >= LEAST_KEPT:
        KEPT.parent.mkdir(exist_ok=True)
        with KEPT.open("a") as file:
            file.write(json.dumps({"key": key, "row": row}) + "\n")
    return row


def _sources() -> list[Path]:
    """Files that a row depends on."""
    import hannes.bench

    return [Path(__file__), *Path(hannes.bench.__file__).parent.glob("*.py")]


def _bounds(row: Row) -> list[Row]:
    """What a row must show; a row that this machine does not allow is missed."""
    name, real_time = f"{row['what']}: ", "real-time" in row["what"]
    if row["notes"] == MISSED:
        return [must_show(f"{name}{MISSED}", 1, 0, False)]
    lost, clock, p99 = row["unmarked"], row["clock [ms]"], row["decision p99 [ms]"]
    bounds = [
        must_show(f"{name}frames lost without a gap", lost, 0, lost == 0),
        must_show(f"{name}clock map off [ms]", clock, 0.1, clock <= 0.1),
    ]
    if real_time or row["what"].startswith("0 busy"):
        quick = 5.0 if real_time else 20.0
        bounds.append(must_show(f"{name}sample to decision, 99 % [ms]", p99, quick, p99 <= quick))
    if real_time:
        worst = row["decision worst [ms]"]
        bounds.append(
            must_show(f"{name}sample to decision, worst [ms]", worst, 50.0, worst <= 50.0)
        )
    return bounds


def _ordinary() -> None:
    """Give this process the priority back that every process has."""
    os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))


def _row(minutes: float, load: int, real_time: bool) -> Row:
    """Record for some minutes; a stand-in decision is made for every sample as it is read."""
    context = multiprocessing.get_context("spawn")
    others = [context.Process(target=_busy, daemon=True) for _ in range(load)]
    for each in others:
        each.start()
    what = f"{load} busy processes, {'real-time' if real_time else 'ordinary'} priority"
    if real_time and "real time" not in raise_priority():
        for each in others:
            each.kill()
        return {"part": "rate", "what": what, "notes": MISSED}
    try:
        with (
            tempfile.TemporaryDirectory() as folder,
            BoardProcess(Misbehaviour(drift=DRIFT)) as board,
        ):
            log = Path(folder) / "run.rawlog"
            return _measured(Link(board.address, real_time=real_time), log, minutes, what)
    finally:
        if real_time:
            _ordinary()
        for each in others:
            each.kill()


def _measured(link: Link, log: Path, minutes: float, what: str) -> Row:
    heard: list[tuple[float, float]] = []
    spent, stolen = time.process_time() + _of_children(), _stolen()
    gc.collect()
    gc.disable()
    with session(link, log) as talk:
        talk.hello()
        until, began = time.monotonic() + 60.0 * minutes, time.monotonic()
        while time.monotonic() < until:
            for event in talk.events():
                if isinstance(event, Sample):
                    heard.append((event.time, time.monotonic()))
            time.sleep(5e-4)
        notes = "; ".join(talk.reader.notes)
        talk.close()
        lasted = time.monotonic() - began
        share = (time.process_time() + _of_children() - spent) / lasted
        stolen = (_stolen() - stolen) / (lasted * (os.cpu_count() or 1))
    gc.enable()
    rows = read_rows(log)
    clock = rows.clock()
    board, moments = np.array(heard).T
    delays = 1e3 * (moments - clock.host(board))
    known = sum(round((b - a) * 1000) - 1 for a, b in gaps(rows.board, 1e-3))
    expected = round((rows.board[-1] - rows.board[0]) * 1000) + 1
    true = -DRIFT  # the board's clock is fast: less host time passes
    return {
        "part": "rate",
        "what": what,
        "frames": rows.board.size,
        "lost": known,
        "unmarked": expected - known - rows.board.size,
        "decision p99 [ms]": float(np.quantile(delays, 0.99)),
        "decision worst [ms]": float(delays.max()),
        "clock [ms]": float(1e3 * abs(clock.drift - true) * (rows.board[-1] - rows.board[0]) / 2),
        "processor share": share,
        "taken by the host": stolen,
        "notes": notes,
    }


def _of_children() -> float:
    """Processor time of the processes that have ended: here the reader's [s]."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def _stolen() -> float:
    """Processor time that the host of a virtual machine gave to others since the start [s]."""
    stat = Path("/proc/stat")
    if not stat.exists():
        return 0.0
    jiffies = int(stat.read_text().splitlines()[0].split()[8])
    return jiffies / float(os.sysconf("SC_CLK_TCK"))


def measure(quick: bool, only: Sequence[str]) -> tuple[list[Row], list[Row]]:
    """Rows and bounds of the parts that are asked for."""
    sizes: dict[str, tuple[Callable[[Any], tuple[list[Row], list[Row]]], float, float]] = {
        "damaged": (damaged, 1_000_000, 20_000),
        "killed": (killed, 50, 3),
        "cable": (cable, 100, 3),
        "rate": (rate, 10.0, 0.05),
    }
    rows, bounds = [], []
    for part in only:
        run, whole, few = sizes[part]
        more, shown = run(few if quick else whole)
        rows, bounds = rows + more, bounds + shown
    return [dict.fromkeys(_keys(rows), "") | row for row in rows], bounds


def _keys(rows: Sequence[Row]) -> list[str]:
    return list(dict.fromkeys(key for row in rows for key in row))


if __name__ == "__main__":
    main(__doc__, "link", measure, PARTS)
