"""Workers that end with the process they work for, however that ends."""

import functools
import os
import threading
import time

EVERY = 0.5  # s between looks


@functools.cache
def end_with(parent: int) -> None:
    """End this process, a worker's, soon after its parent has gone.

    A thread looks whose child this is: a system gives orphans another parent. Where a process keeps
    the number of a dead parent (Windows) it asks whether that still runs.
    """
    if parent == os.getpid():
        return
    threading.Thread(target=_watch, args=(parent,), daemon=True, name="parent").start()


def _watch(parent: int) -> None:
    while _lives(parent):
        time.sleep(EVERY)
    os._exit(1)


def _lives(parent: int) -> bool:
    if os.name != "nt":
        return os.getppid() == parent
    import ctypes

    handle = ctypes.windll.kernel32.OpenProcess(0x00100000, False, parent)  # type: ignore[attr-defined]  # SYNCHRONIZE
    if not handle:
        return False
    alive = ctypes.windll.kernel32.WaitForSingleObject(handle, 0) != 0  # type: ignore[attr-defined]
    ctypes.windll.kernel32.CloseHandle(handle)  # type: ignore[attr-defined]
    return bool(alive)
