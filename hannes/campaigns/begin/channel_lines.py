"""Lines of a mapping about one channel: column, unit, and what its numbers and its name show."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from hannes.campaigns.begin.channel_words import plain, surely_from_supply, words_of
from hannes.campaigns.begin.column_guess import Guess
from hannes.campaigns.begin.mapping_draft import FILL_IN, Draft
from hannes.campaigns.begin.text_layout import TextLayout

FloatArray = NDArray[np.float64]

TURNS = (256.0, 1024.0, 2048.0, 4096.0, 8192.0, 16384.0, 32768.0, 65536.0, 360.0, 1e9)
NEAR = 0.03  # of a turn: how close to it a jump must be


def channel_lines(
    made: Draft,
    channel: str,
    guess: Guess,
    values: FloatArray | None,
    doubtful: Sequence[Guess],
    layout: TextLayout | None,
    duty: bool,
) -> None:
    """Write the table of one channel; `duty`: whether the duty was recorded, too."""
    add = made.lines.append
    add(f"\n[channels.{channel}]")
    others = [str(each.column) for each in doubtful if each.channel == channel]
    if others:
        either = ", ".join([name_of(guess), *map(quoted, others)])
        add(f'column = "{FILL_IN}"  # one of {either}')
    else:
        add(f"column = {name_of(guess)}  # {guess.why}")
    if others:
        made.ask(f'which of "{guess.column}", {", ".join(others)} is {channel}?')
    if layout is not None and _holds_lists(layout, guess.column):
        add(f'index = "{FILL_IN}"  # its cells are lists; the place, from 1, without quotes')
        made.ask(f"which place of the lists in {guess.column} is {channel}?")
    if guess.unit == "counts":
        add(f'unit = "{FILL_IN}"  # raw counts: the unit of one count, and how much it is')
        add(f'scale = "{FILL_IN}"')
        made.ask(f"unit and scale of one count of {channel} ({guess.column})")
    elif not guess.unit:
        add(f'unit = "{FILL_IN}"')
        made.ask(f'the unit of {channel} ("{guess.column}")')
    else:
        add(f'unit = "{guess.unit}"')
    if guess.supply:
        _at_the_supply(made, guess, duty)
    if values is not None:
        _raw(made, channel, values)
    label = "" if guess.why.endswith(f'"{guess.column}"') else f", {guess.why}"
    made.seen.append(f'{channel}: "{guess.column}" [{guess.unit or FILL_IN}]{label}')


def _at_the_supply(made: Draft, guess: Guess, duty: bool) -> None:
    """A current whose name says that the supply gives it: the motor's is that over the duty."""
    words = [plain(word) for word in words_of(str(guess.column))]
    if duty and surely_from_supply(words):
        made.lines.append('kind = "supply"  # its name says so: it is divided by the duty')
        made.seen.append(f'"{guess.column}" is drawn from the supply: divided by the duty')
        return
    made.lines.append(f'kind = "{FILL_IN}"  # "motor"; "supply" needs [channels.duty]')
    if duty:
        made.ask(f'is "{guess.column}" of the supply (kind = "supply") or the motor ("motor")?')
        return
    made.ask(
        f'"{guess.column}" is drawn from the supply, so it needs the column of the duty; or is it '
        'the motor\'s (kind = "motor")?'
    )


def _holds_lists(layout: TextLayout, column: str | int) -> bool:
    """Whether the cells of a column are lists."""
    if column not in layout.names:
        return False
    place = layout.names.index(str(column))
    cell = layout.rows[0][place] if place < len(layout.rows[0]) else ""
    return cell[:1] in ("[", "(")


def _raw(made: Draft, channel: str, values: FloatArray) -> None:
    """Signs and wraps that the numbers themselves show."""
    known = values[np.isfinite(values)]
    if known.size and np.all(known == np.round(known)) and known.min() >= 0.0:
        for bits in (16, 32):
            high = known > 2.0 ** (bits - 1)
            if known.max() < 2.0**bits and high.any() and (known[~high] < 2.0 ** (bits - 2)).all():
                made.lines.append(
                    f"signed = {bits}  # values near {known.max():.0f} are below zero"
                )
                made.seen.append(f"{channel}: {bits}-bit numbers without their sign")
                return
    if turn := wrapped(values):
        made.lines.append(f"unwrap = {turn:g}  # jumps by one turn")
        made.seen.append(f"{channel}: a counter that begins anew after {turn:g}")


def wrapped(values: FloatArray) -> float:
    """The turn after which a counter begins anew, 0 where there is no such jump."""
    known = values[np.isfinite(values)]
    if known.size < 3:
        return 0.0
    steps = np.diff(known)
    jumps = steps[np.abs(steps) > 20.0 * max(float(np.median(np.abs(steps))), 1e-12)]
    for turn in TURNS:
        if known.max() > turn or known.min() < 0.0 or not jumps.size:
            continue
        if np.all(np.abs(np.abs(jumps) - turn) < NEAR * turn):
            return turn
    return 0.0


def quoted(text: str) -> str:
    """A text as TOML has it."""
    escaped = text.replace("\\", "\\\\").replace('"', '\\"')
    return f'"{escaped}"'


def name_of(guess: Guess) -> str:
    """A guess's column as TOML has it."""
    return str(guess.column) if isinstance(guess.column, int) else quoted(guess.column)
