"""Runs one command; before or after one of its calls that write or rename it gets a signal."""

import json
import os
import signal
import sys
import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from benchmarks.kills.processor_time import seconds


@dataclass(frozen=True)
class Hit:
    """Which call a signal comes before or after: number 0 means none; `note`: see `main`."""

    number: int = 0
    when: str = "before"
    signal: str = "SIGKILL"
    note: str = ""


def main(hit: Hit, arguments: Sequence[str]) -> int:
    """Run a command; write into the file `hit.note` what it called, imported and had set.

    The calls are os.fsync, os.replace, os.rename and the exchange of two folders.
    """
    calls, found = [0], dict[str, Any]()

    def watched(call: Callable[..., Any]) -> Callable[..., Any]:
        def called(*given: Any, **how: Any) -> Any:
            calls[0] += 1
            mine = calls[0] == hit.number
            if calls[0] == 1 and hit.note:
                found.update(_state())
            if mine and hit.when == "before":
                os.kill(os.getpid(), getattr(signal, hit.signal))
            given_back = call(*given, **how)
            if mine and hit.when == "after":
                os.kill(os.getpid(), getattr(signal, hit.signal))
            return given_back

        return called

    for name in ("fsync", "replace", "rename"):
        setattr(os, name, watched(getattr(os, name)))
    from hannes.core.io import atomic_files

    atomic_files._exchange = watched(atomic_files._exchange)
    from hannes.commands import cli

    status = cli.main(arguments)
    if hit.note:
        found |= {
            "calls": calls[0],
            "modules": sorted(sys.modules),
            "seconds": seconds(os.getpid()),
        }
        Path(hit.note).write_text(json.dumps(found))
    return status


def _state() -> dict[str, Any]:
    """What becomes of each signal within a command, and the threads that there are."""
    handlers = {each.name: signal.getsignal(each) for each in signal.valid_signals()
                if isinstance(each, signal.Signals)}  # fmt: skip
    return {
        "handlers": {
            name: getattr(each, "__qualname__", str(each)) for name, each in handlers.items()
        },
        "blocked": sorted(map(int, signal.pthread_sigmask(signal.SIG_BLOCK, []))),
        "threads": sorted(each.name for each in threading.enumerate()),
        "in the main thread": threading.current_thread() is threading.main_thread(),
    }


if __name__ == "__main__":
    sys.exit(main(Hit(**json.loads(sys.argv[1])), sys.argv[2:]))
