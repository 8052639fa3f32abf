"""The regular expression of lines that a mapping leaves out: one that cannot take for ever.

Python's engine goes back and tries again. A repeated group takes a time that is exponential in the
length of a line, and k repetitions of one character take that length to the power of k. So groups
are not repeated, characters not more than REPEATS times, and a line is looked at up to SEARCHED.
"""

import re
import warnings

from hannes.core.io.limits import REPEATS, SEARCHED
from hannes.core.io.toml_table import Table

LONGEST = 200  # characters of a pattern
_ONE_CHARACTER = re.compile(r"\\.|\[\^?\]?(?:\\.|[^\]\\])*\]", re.DOTALL)
_REFERENCE = re.compile(r"\\[1-9]")
_SPECIAL_GROUP = re.compile(r"\(\?(?!:)")
_REPEATED_GROUP = re.compile(r"\)[*+?{]")
_REPEAT = re.compile(r"[*+{]|(?<!\()\?")


def skip_pattern(table: Table, key: str) -> str:
    """Return a regular expression that is quick on every line; refuse others in one line."""
    given = table.text(key, "")
    if len(given) > LONGEST:
        table.refuse(key, f"is longer than {LONGEST} characters")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            re.compile(given)
    except (re.error, OverflowError, RecursionError) as error:
        table.refuse(key, f'= "{given[:60]}" is no regular expression ({error})')
    if why := _slow(given):
        table.refuse(key, f'= "{given[:60]}" {why}, which may take for ever; give a simpler one')
    return given


def _slow(given: str) -> str:
    """Why a pattern may be slow; empty where it is not."""
    if any(map(_REFERENCE.match, _ONE_CHARACTER.findall(given))):
        return "refers back to a group"
    plain = _ONE_CHARACTER.sub("x", given)
    if _SPECIAL_GROUP.search(plain):
        return "has a group that begins with (? and is not (?:"
    if _REPEATED_GROUP.search(plain):
        return "repeats a group"
    if len(_REPEAT.findall(plain)) > REPEATS:
        return f"has more than {REPEATS} repetitions"
    return ""


def skipper(given: str) -> re.Pattern[str] | None:
    """What `leaves_out` asks, None where nothing is left out."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return re.compile(given) if given else None


def leaves_out(pattern: re.Pattern[str] | None, line: str) -> bool:
    """Whether a line is left out."""
    return pattern is not None and pattern.search(line[:SEARCHED]) is not None
