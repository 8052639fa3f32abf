"""Progress of long work: a bar in a terminal or a notebook; a line a stage in a pipe, if asked."""

import sys
import time
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

DELAY = 2.0  # s, before a bar is shown
Report = Callable[[str, str], None]


def progress_bar(*args: Any, **options: Any) -> Any:
    """tqdm's bar as the place can show it; arguments are tqdm's, `disable` by the place alone.

    In a notebook it is a widget where ipywidgets is installed, else text.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # text serves as well as a widget
        from tqdm.auto import tqdm
    hidden = options.pop("disable", None)
    if hidden is None and in_notebook():
        hidden = False
    return tqdm(*args, disable=hidden, **options)


@contextmanager
def stages(task: str, unit: str, shown: bool | None = None) -> Iterator[Report]:
    """Yield `report(stage, detail)`, to be called at every step of a long task.

    In a terminal or a notebook it moves a bar, after two seconds. `shown` is True: elsewhere it
    prints one line on standard error for each stage, when that begins; None: only where there is a
    bar; False: nothing. `unit`: of the steps.
    """
    if shown and sys.stderr is not None and not (sys.stderr.isatty() or in_notebook()):
        yield _lines(task)
        return
    hidden = None if shown is None else not shown
    with progress_bar(desc=task, unit=unit, delay=DELAY, disable=hidden, leave=False) as bar:

        def report(stage: str, detail: str) -> None:
            bar.set_description(_joined(stage, detail), refresh=False)
            bar.update()

        yield report


def _lines(task: str) -> Report:
    """Print a line whenever the stage is another one."""
    begun, last = time.monotonic(), ""

    def report(stage: str, detail: str) -> None:
        nonlocal last
        if stage != last:
            last, elapsed = stage, time.monotonic() - begun
            print(f"{task}, {elapsed:.0f} s: {_joined(stage, detail)}", file=sys.stderr, flush=True)

    return report


def _joined(stage: str, detail: str) -> str:
    return f"{stage}, {detail}" if detail else stage


def in_notebook() -> bool:
    """Return whether a notebook's kernel runs this process."""
    shell = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    return type(shell).__name__ == "ZMQInteractiveShell"
