"""A process that has imported what a command imports, and forks a process for each command.

A start of Python with numpy, numba and scipy takes longer than most commands: so a hundred kills
cost a hundred commands, not a hundred starts. The forked process does what a fresh one does from
there on: it unwinds to the top, runs the command and ends as Python ends.

It reads a line of JSON: the names of modules. Then, for each command, a line: folder, mark, how it
is hit, arguments and a file for its words. It answers with the number of the process, and with
its exit status.
"""

import importlib
import json
import os
import sys
from contextlib import suppress
from typing import Any

MARK = "HANNES_KILLS_RUN"  # in the environment of a command and of all that it starts


def main() -> int:
    """Serve until standard input ends; in a forked process: run the command."""
    order = _served()
    if order is None:
        return 0
    os.setsid()
    os.chdir(order["folder"])
    os.environ[MARK] = order["mark"]
    null, words = os.open(os.devnull, os.O_RDWR), os.open(order["words"], os.O_RDWR | os.O_CREAT)
    for number, opened in enumerate((null, null, words)):
        os.dup2(opened, number)
    os.close(null)
    os.close(words)
    from benchmarks.kills import watched

    return watched.main(watched.Hit(**order["hit"]), order["arguments"])


def _served() -> dict[str, Any] | None:
    for name in json.loads(sys.stdin.readline()):
        with suppress(Exception):
            importlib.import_module(name)
    for line in sys.stdin:
        child = os.fork()
        if child == 0:
            order: dict[str, Any] = json.loads(line)
            return order
        print(child, flush=True)
        print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), flush=True)
    return None


if __name__ == "__main__":
    sys.exit(main())
