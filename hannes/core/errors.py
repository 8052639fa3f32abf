"""Errors that hannes reports to its user, each kind with its exit status."""

import difflib
from collections.abc import Iterable


def printable(text: object) -> str:
    """Text on one line that no terminal takes for a command: a file's name may hold anything."""
    return "".join(each if each.isprintable() else "?" for each in str(text))


class HannesError(Exception):
    """Any failure that hannes itself reports; its text is one line for the user.

    Texts of files may stand in it: what is not printable becomes a question mark.
    """

    exit_status = 1

    def __init__(self, text: str = "") -> None:
        super().__init__(printable(text))

    def __eq__(self, other: object) -> bool:
        return type(other) is type(self) and vars(other) == vars(self) and str(other) == str(self)

    def __hash__(self) -> int:
        return hash((type(self), str(self)))


class BadInput(HannesError):
    """The input cannot be used: what was expected, what came, what to do.

    `mend`: lines to be added to a mapping, where one of its keys helps.
    """

    exit_status = 2

    def __init__(self, text: str = "", mend: tuple[str, ...] = ()) -> None:
        super().__init__(text)
        self.mend = mend

    def __repr__(self) -> str:
        return f"{type(self).__name__}({str(self)!r}{f', mend={self.mend!r}' if self.mend else ''})"


class NotTrusted(BadInput):
    """Nobody consented to the Python that a file names."""


class MissingRecording(BadInput):
    """A third-party recording is neither on this machine nor downloadable."""


class ComputationFailed(HannesError):
    """The input was sound but the computation itself failed (solver, fit)."""

    exit_status = 3


class Interrupted(HannesError):
    """The user ended a computation; its results so far are kept."""

    exit_status = 130


def nearest(name: str, names: Iterable[str]) -> str:
    """Return a did-you-mean clause for a misspelt `name`, or an empty string."""
    close = difflib.get_close_matches(name, list(names), n=1, cutoff=0.5)
    return f'; did you mean "{close[0]}"?' if close else ""
