"""The raw log that a command on a port leaves, however it ends: made a recording, and named."""

import shlex
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from hannes.core.recording.recording import Recording


def write_what_came(
    raw: Path, out: Path, verb: str, finished: "Callable[[Recording], Recording] | None" = None
) -> None:
    """Write the recording of a command that has ended or was broken off; say what there is.

    finished: adds what is not in the raw log. Raises no error of its own: what ended the command is
    said after it.
    """
    if not raw.exists():
        return
    from hannes.bench.record import recover
    from hannes.core.errors import HannesError
    from hannes.core.recording.marked import write_marked

    try:
        made = recover(raw, _say)
        made = finished(made) if finished else made
        write_marked(made, out, verb)
    except (HannesError, OSError, KeyboardInterrupt) as error:
        _say(f"no recording: {error or 'interrupted'}")
        say_what_is_left(raw, out)
        return
    _say(f"wrote {out}: {made.time.size} samples, all that came")
    say_what_is_left(raw, "FILE")


def say_what_is_left(raw: Path, out: str | Path) -> None:
    """Say where the bytes are that came, and what makes a recording of them as `out`.

    Where they hold none, that is said.
    """
    from hannes.bench.record import recover
    from hannes.core.errors import BadInput

    if not raw.exists():
        return
    try:
        recover(raw)
    except BadInput:
        _say(f"{raw} has no sample of the board: delete it before you record there again")
    else:
        command = f"hannes record --recover {shlex.quote(str(raw))} --out {shlex.quote(str(out))}"
        _say(f"the raw bytes are in {raw}; `{command}` makes a recording of them")


def _say(text: str) -> None:
    print(f"hannes: {text}", file=sys.stderr, flush=True)
