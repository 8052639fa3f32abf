"""The command's edge: however a command ends, it says so in one line and an exit status."""

import datetime
import os
import signal
import sys
import tempfile
import threading
import traceback
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from types import FrameType
from typing import Any

from hannes.core.errors import HannesError, printable
from hannes.core.io.cache import cache_home

OUT_OF_MEMORY, UNFORESEEN = 3, 70
INTERRUPTED, PIPE_CLOSED = 130, 141  # what a shell reports for SIGINT and SIGPIPE
BAD_INPUT = 2


def guarded(work: Callable[[], Any], arguments: Sequence[str]) -> int:
    """Do `work`, the command of `arguments`; return its exit status, whatever happens in it."""
    _fill_standard_streams()
    try:
        with _ended_like_interrupts(), _watched_output():
            work()
            sys.stdout.flush()
        return 0
    except HannesError as error:
        _say(str(error))
        return error.exit_status
    except KeyboardInterrupt:
        _say("interrupted; earlier results are as they were")
        return INTERRUPTED
    except BrokenPipeError:
        # Whoever read us has gone; Python would complain once more when it flushes at exit.
        _silence()
        return PIPE_CLOSED
    except _OutputLost as error:
        _silence()
        _say(f"cannot write to standard output: {error}")
        return BAD_INPUT
    except MemoryError:
        _say("there is not enough memory for this; earlier results are as they were")
        return OUT_OF_MEMORY
    except OSError as error:
        return _system(error, arguments)
    except Exception as error:
        return _unforeseen(error, arguments)


def _system(error: OSError, arguments: Sequence[str]) -> int:
    """A fault of the system, about a file that it names."""
    if error.filename and error.errno:
        _say(f"{os.fsdecode(error.filename):.300}: {error.strerror or error}")
        return BAD_INPUT
    return _unforeseen(error, arguments)


def _unforeseen(error: Exception, arguments: Sequence[str]) -> int:
    """Keep the details in a file; say what was done, where they are and what to do with them."""
    command = " ".join(["hannes", *arguments])
    details = "".join(traceback.format_exception(error))
    place = _kept(f"{command}\n{sys.version}\n\n{details}")
    what = f"{type(error).__name__}: {error}"
    _say(
        f"`{command:.200}` failed in a way that nobody foresaw ({what:.200}); details are in "
        f"{place}: please report it, with that file, to where you have hannes from"
    )
    return UNFORESEEN


def _kept(text: str) -> str:
    name = f"{datetime.datetime.now():%Y%m%d-%H%M%S}-{os.getpid()}.txt"
    for folder in (lambda: cache_home() / "errors", lambda: Path(tempfile.gettempdir())):
        with suppress(OSError, HannesError):
            (place := folder()).mkdir(parents=True, exist_ok=True)
            (place / name).write_text(text, encoding="utf-8", errors="replace")
            return str(place / name)
    return "no file, as none could be written"


def _say(text: str) -> None:
    line = printable(" ".join(text.split()))
    with suppress(OSError, ValueError):
        print(f"hannes: {line}", file=sys.stderr, flush=True)


class _OutputLost(Exception):
    """Standard output takes no more."""


class _Watched:
    """A stream that separates its own faults from those of other files."""

    def __init__(self, stream: Any) -> None:
        self._stream = stream

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    def write(self, text: str) -> int:
        """Write what the stream's encoding has, and codes of what it has not."""
        encoding = getattr(self._stream, "encoding", None) or "utf-8"
        shown = text.encode(encoding, "backslashreplace").decode(encoding)
        return self._guarded(self._stream.write, shown)

    def flush(self) -> None:
        self._guarded(self._stream.flush)

    @staticmethod
    def _guarded(call: Callable[..., Any], *given: str) -> Any:
        try:
            return call(*given)
        except BrokenPipeError:
            raise
        except OSError as error:
            raise _OutputLost(error.strerror or error) from None


@contextmanager
def _watched_output() -> Iterator[None]:
    stream = sys.stdout
    watched: Any = _Watched(stream)
    sys.stdout = watched
    try:
        yield
    finally:
        if sys.stdout is watched:
            sys.stdout = stream


def _silence() -> None:
    """Let what is left for standard output go nowhere."""
    with suppress(OSError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _fill_standard_streams() -> None:
    """Put the null device where a standard stream is closed: no file shall take its number."""
    for number in range(3):
        with suppress(OSError):
            try:
                os.fstat(number)
            except OSError:
                os.open(os.devnull, os.O_RDWR)  # gets the lowest free number
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, "w", encoding="utf-8"))


@contextmanager
def _ended_like_interrupts() -> Iterator[None]:
    """Within, SIGTERM and SIGHUP end a command as Ctrl-C does, where they would kill it."""
    numbers = [getattr(signal, name) for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name)]
    if threading.current_thread() is not threading.main_thread():
        numbers = []
    taken = [each for each in numbers if signal.getsignal(each) is signal.SIG_DFL]
    for each in taken:
        signal.signal(each, _interrupt)
    try:
        yield
    finally:
        for each in taken:
            signal.signal(each, signal.SIG_DFL)


def _interrupt(number: int, frame: FrameType | None) -> None:
    raise KeyboardInterrupt
