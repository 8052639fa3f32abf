"""What a live grasp looks like in a terminal: a process of its own, which may be slow.

The grasp's loop hands moments over and never waits: where the display is behind, it misses some.
In a pipe there are plain lines instead.
"""

import contextlib
import multiprocessing
import queue
import time
from collections import deque
from collections.abc import Iterator, Sequence
from itertools import pairwise
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

from hannes.bench.live_run import Moment

if TYPE_CHECKING:
    from rich.console import Console, ConsoleOptions, RenderableType

BARS = "▁▂▃▄▅▆▇█"
KEPT = 600  # moments that a trace shows, some five seconds
NAMES_WIDE, VALUES_WIDE = 9, 24  # characters
AROUND = NAMES_WIDE + VALUES_WIDE + 10  # of what is beside a trace, its border with it
WAITING = 200  # moments that the display may be behind
LINE = 0.25  # s between two plain lines
TRACES = (("position", "rad", 1.0), ("current", "A", 0.2))  # and the least span of a trace
LEAST_FORCE = 5.0  # N, likewise


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
        if moment.released and self._word:
            self._word = ""
            print(f"{moment.time:9.3f} s  let go", flush=True)
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
                shown.update(Picture(title, kept))
                time.sleep(0.02)


class Picture:
    """Traces, verdict, confidence, force and link of the moments so far, as wide as the terminal.

    At least 60 columns are wanted; at 80 by 24 nothing is cut off.
    """

    def __init__(self, title: str, kept: "Sequence[Moment]") -> None:
        self.title, self.kept = title, list(kept)

    def __rich_console__(
        self, console: "Console", options: "ConsoleOptions"
    ) -> "Iterator[RenderableType]":
        from rich.panel import Panel
        from rich.table import Table

        rows = Table.grid(padding=(0, 2))
        rows.add_column(width=NAMES_WIDE)
        rows.add_column(width=(wide := max(options.max_width - AROUND, 10)), no_wrap=True)
        rows.add_column(width=VALUES_WIDE, no_wrap=True)
        for row in (*self._traces(wide), *self._said(), self._link()):
            rows.add_row(*row)
        yield Panel(rows, title=self.title)

    def _traces(self, wide: int) -> "Iterator[tuple[str, str, str]]":
        for name, unit, span in TRACES:
            values = [each.values.get(name, 0.0) for each in self.kept]
            yield name, trace(values, wide, span), f"{values[-1]:.2f} {unit}"
        forces = [each.force.value if each.force else 0.0 for each in self.kept]
        last = self.kept[-1].force
        band = f"{last.value:.1f} N ({last.low:.1f} to {last.high:.1f})" if last else "-"
        yield "force", trace(forces, wide, LEAST_FORCE), band

    def _said(self) -> "Iterator[tuple[str, str, str]]":
        last = self.kept[-1]
        decision = next((each.decision for each in reversed(self.kept) if each.decision), None)
        if last.released:
            yield "verdict", "[bold]nothing held[/bold]", ""
        elif decision is not None:
            yield "verdict", f"[bold]{decision.word}[/bold]", f"P(rigid) {decision.rigid:.2f}"
            stiff = decision.stiffness
            said = f"{stiff.value:.0f} N/m ({stiff.low:.0f} to {stiff.high:.0f})" if stiff else "-"
            yield "stiffness", said, "held firmly" if last.firm else ""
        if last.force is not None and last.force.warns:
            words = "[red]the machine has left the model[/red]"
            yield "residual", words, f"{last.force.residual:.1f}"

    def _link(self) -> tuple[str, str, str]:
        last = self.kept[-1]
        return (
            "link",
            f"damaged {last.damaged}, gaps {last.gaps}; stop: Ctrl-C",
            f"{last.time:.2f} s",
        )


def trace(values: Sequence[float], wide: int, least_span: float) -> str:
    """All values as `wide` bars of means; what spans less than `least_span` is nearly flat."""
    count = min(wide, len(values))
    edges = [k * len(values) // count for k in range(count + 1)]
    means = [sum(values[i:j]) / (j - i) for i, j in pairwise(edges)]
    least = min(means)
    span = max(max(means) - least, least_span)
    return "".join(BARS[round((len(BARS) - 1) * (each - least) / span)] for each in means)
