"""Processor time of a process that runs, and of its children (Linux)."""

import time
from contextlib import suppress
from pathlib import Path


def seconds(pid: int) -> float:
    """Processor time [s] of a process and its children, each as long as it runs."""
    return _own(pid) + sum(map(_own, _children(pid)))


def _own(pid: int) -> float:
    with suppress(OSError):
        return time.clock_gettime((~pid << 3) | 2)  # as clock_getcpuclockid of glibc has it
    return 0.0


def _children(pid: int) -> list[int]:
    with suppress(OSError):
        return [int(x) for x in Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]
    return []
