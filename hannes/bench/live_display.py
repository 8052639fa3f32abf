"""What a live grasp looks like in a terminal: a process of its own, which may be slow.

The grasp's loop hands moments over and never waits: where the display is behind, it misses some.
In a pipe there are plain lines instead.
"""

import contextlib
import multiprocessing
import queue
import time
from collections import deque
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

from hannes.bench.live_run import Moment

if TYPE_CHECKING:
    from rich.console import RenderableType

BARS = " ▁▂▃▄▅▆▇█"
WIDTH, KEPT = 60, 300  # characters of a trace, moments that it shows
WAITING = 200  # moments that the display may be behind
LINE = 0.25  # s between two plain lines
TRACES = (("position", "rad"), ("current", "A"))


class Display:
    """Shows moments on the terminal from a process of its own."""

    def __init__(self, title: str) -> None:
        context = multiprocessing.get_context("spawn")
        self._queue: Any = context.Queue(WAITING)
        self._process = context.Process(target=_show, args=(title, self._queue), daemon=True)
        self._process.start()

    def put(self, moment: Moment) -> None:
        """Hand a moment over; dropped where the display is behind."""
        with contextlib.suppress(queue.Full):
            self._queue.put_nowait(moment)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        with contextlib.suppress(queue.Full):
            self._queue.put(None, timeout=1.0)
        self._process.join(2.0)
        if self._process.is_alive():
            self._process.kill()


class PlainLines:
    """Shows moments as lines: one where the verdict changes, else four a second."""

    def __init__(self) -> None:
        self._word, self._printed = "", -LINE

    def put(self, moment: Moment) -> None:
        """Print the moment where a line is due."""
        if moment.decision is None:
            return
        word = moment.decision.word
        if word != self._word or moment.time - self._printed >= LINE:
            self._word, self._printed = word, moment.time
            print(plain_line(moment), flush=True)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        return


def plain_line(moment: Moment) -> str:
    """A moment with a decision as one line."""
    decision, force = moment.decision, moment.force
    assert decision is not None
    parts = [f"{moment.time:9.3f} s", f"{decision.word:<10}", f"P(rigid) {decision.rigid:.2f}"]
    if decision.stiffness is not None:
        found = decision.stiffness
        parts.append(f"{found.value:.0f} N/m ({found.low:.0f} to {found.high:.0f})")
    if force is not None:
        parts.append(f"{force.value:.1f} N ({force.low:.1f} to {force.high:.1f})")
        if force.warns:
            parts.append("the machine has left the model")
    if moment.firm:
        parts.append("held firmly")
    return "  ".join(parts)


def _show(title: str, moments: Any) -> None:
    """Body of the process."""
    import signal

    from rich.live import Live

    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the grasp's own process decides
    kept: deque[Moment] = deque(maxlen=KEPT)
    with Live(refresh_per_second=15) as shown:
        while (moment := moments.get()) is not None:
            kept.append(moment)
            if moments.empty():
                shown.update(panel(title, kept))
                time.sleep(0.02)


def panel(title: str, kept: "deque[Moment]") -> "RenderableType":
    """Traces, verdict, confidence, force and link of the moments so far."""
    from rich.panel import Panel
    from rich.table import Table

    rows = Table.grid(padding=(0, 2))
    for name, unit in TRACES:
        values = [each.values.get(name, 0.0) for each in kept]
        rows.add_row(name, trace(values), f"{values[-1]:.2f} {unit}")
    forces = [each.force.value if each.force else 0.0 for each in kept]
    last = kept[-1].force
    band = f"{last.value:.1f} N ({last.low:.1f} to {last.high:.1f})" if last else "-"
    rows.add_row("force", trace(forces), band)
    decision = next((each.decision for each in reversed(kept) if each.decision), None)
    if decision is not None:
        bar = trace([decision.rigid] * 10, 0.0, 1.0)
        rows.add_row("verdict", f"[bold]{decision.word}[/bold]", f"{bar} {decision.rigid:.2f}")
        stiff = decision.stiffness
        said = f"{stiff.value:.0f} N/m ({stiff.low:.0f} to {stiff.high:.0f})" if stiff else "-"
        rows.add_row("stiffness", said, "held firmly" if kept[-1].firm else "")
    if last is not None and last.warns:
        rows.add_row(
            "residual", "[red]the machine has left the model[/red]", f"{last.residual:.1f}"
        )
    link = f"{kept[-1].damaged} damaged frames, {kept[-1].gaps} gaps; stop with Ctrl-C"
    rows.add_row("link", link, f"{kept[-1].time:.2f} s")
    return Panel(rows, title=title)


def trace(values: list[float], low: float | None = None, high: float | None = None) -> str:
    """The newest values as bars, from the least to the most of them."""
    some = values[-WIDTH:]
    least = min(some) if low is None else low
    span = ((max(some) if high is None else high) - least) or 1.0
    return "".join(BARS[round((len(BARS) - 1) * min(max((v - least) / span, 0), 1))] for v in some)
