"""A mapping as text to be edited: what was seen, and in words what has to be filled in."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hannes.campaigns.begin.channel_lines import channel_lines, name_of, quoted, wrapped
from hannes.campaigns.begin.column_guess import Guess
from hannes.campaigns.begin.mapping_draft import FILL_IN, Draft
from hannes.campaigns.begin.stamp_form import form_of_stamps
from hannes.campaigns.begin.text_layout import TextLayout
from hannes.campaigns.foreign.raw_values import COARSE

FloatArray = NDArray[np.float64]

STARTS, SHORT_START = 10, 8  # beginnings of lines that are left out, and characters of each
SHOWN = 20  # columns that are not used, on the terminal


def draft(
    files: Sequence[Path],
    plant: str,
    layout: TextLayout | None,
    chosen: dict[str, Guess],
    doubtful: Sequence[Guess],
    columns: Mapping[str, FloatArray],
    split: str,
    required: Sequence[str],
) -> Draft:
    """Write the mapping of files that share one layout (None: a binary format).

    chosen: guess by channel, `time` among them; doubtful: other guesses for the same channels;
    columns: numbers (n,) by name or number; required: channels without which nothing can be done.
    """
    made = Draft()
    add = made.lines.append
    add(f"# How {files[0].name} and its like become recordings; made by `hannes begin`")
    add(f'# Lines with "{FILL_IN}" are to be filled in; all keys: docs/reference/mapping.md')
    add(f'plant = "{plant}"')
    if layout is not None and layout.missing:
        add(f"missing = {_texts(layout.missing)}")
    _runs(
        made, layout, split, columns.get(str(chosen["time"].column)) if "time" in chosen else None
    )
    if layout is not None:
        _text(made, layout)
    _time(made, chosen.get("time"), columns, layout)
    for channel, guess in chosen.items():
        if channel != "time":
            values = columns.get(str(guess.column))
            channel_lines(made, channel, guess, values, doubtful, layout, "duty" in chosen)
    for channel in required:
        if channel not in chosen:
            made.ask(f"which column is {channel}? ([channels.{channel}])")
            add(f'\n[channels.{channel}]\ncolumn = "{FILL_IN}"  # none has a name that says so')
            add(f'unit = "{FILL_IN}"')
    _not_used(made, chosen, doubtful, columns, split)
    return made


def _not_used(
    made: Draft,
    chosen: dict[str, Guess],
    doubtful: Sequence[Guess],
    columns: Mapping[str, FloatArray],
    split: str,
) -> None:
    """Name every column of numbers that no channel takes."""
    used = {split, *(str(each.column) for each in (*chosen.values(), *doubtful))}
    sizes = {columns[name].size for name in used if name in columns}
    rest = {name: x for name, x in columns.items() if name not in used}
    left = [name for name, x in rest.items() if not sizes or x.size in sizes]
    if not left:
        return
    made.lines[2:2] = [f"# not used: {' '.join(', '.join(left).split())}"]
    more = f" and {len(left) - SHOWN} more, see the mapping" if len(left) > SHOWN else ""
    made.seen.append(f"not used: {', '.join(left[:SHOWN])}{more}")


def _texts(texts: Sequence[str]) -> str:
    return "[" + ", ".join(quoted(each) for each in texts) + "]"


def _runs(made: Draft, layout: TextLayout | None, split: str, clock: FloatArray | None) -> None:
    """Where one run ends and the next begins."""
    if split:
        made.lines.append(f"split = {quoted(split)}  # a new run wherever it changes")
        made.seen.append(f'runs by the column "{split}"')
    elif layout is not None and layout.headers:
        made.lines.append('split_at = "header"  # the line of names stands before every run')
        made.seen.append("a run after each repeated header")
    elif clock is not None and _begins_anew(clock) and not wrapped(clock):
        made.lines.append('split_at = "restart"  # its time begins anew')
        made.seen.append("a run wherever time begins anew")
    elif layout is not None and layout.blanks:
        made.lines.append('split_at = "blank"  # a blank line stands between runs')
        made.seen.append("a run after each blank line")


def _begins_anew(clock: FloatArray) -> bool:
    """Whether a clock goes back by most of what had passed, more often than a stamp is late."""
    from hannes.campaigns.foreign.raw_values import restarts

    return restarts(clock).size > 0


def _text(made: Draft, layout: TextLayout) -> None:
    add = made.lines.append
    add("\n[text]")
    add(f'delimiter = "{layout.delimiter}"')
    add(f'decimal = "{layout.decimal}"')
    if layout.comment:
        add(f'comment = "{layout.comment}"')
    add(f"header = {layout.header}  # line with the names, 0 for none")
    add(f"first = {layout.first}  # line of the first numbers")
    if layout.form is not None and layout.form.stamped:
        add("stamped = true  # a serial monitor wrote its time before each line")
        made.seen.append("a serial monitor's stamp before each line")
    if layout.form is not None and layout.form.mark:
        add(f'pairs = "{layout.form.mark}"  # a name before each value')
        made.seen.append("a name before each value; lines without are left out")
    if layout.encoding != "utf-8":
        add(f'encoding = "{layout.encoding}"')
    if odd := [
        line for line in layout.odd if not (layout.comment and line.startswith(layout.comment))
    ]:
        skipped = quoted(_expression(odd, layout.samples))
        add(f"skip = {skipped}  # lines such as {odd[0].strip()[:40]!r}")
        made.seen.append(f"{len(odd)} lines that are no samples, left out")
    if layout.ragged:
        add("ragged = true  # rows are of unequal length")
    delimiter = {"tab": "tabs", "space": "spaces"}.get(layout.delimiter, layout.delimiter + "s")
    names = f"names in line {layout.header}" if layout.header else "no line of names"
    made.seen.append(f"text, divided by {delimiter}, decimal {layout.decimal!r}, {names}")


def _expression(odd: Sequence[str], samples: Sequence[str]) -> str:
    """A regular expression of the beginnings of lines, none of them that of a sample."""
    starts = sorted({_start(line.strip(), samples) for line in odd if line.strip()})
    return f"^\\s*({'|'.join(starts[:STARTS])})"


def _start(line: str, samples: Sequence[str]) -> str:
    """The shortest beginning of a line, from a word on, with which no sample begins."""
    import re

    same = [each.strip() for each in samples]
    for size in range(min(len(line.split()[0]), SHORT_START), len(line) + 1):
        same = [each for each in same if each.startswith(line[:size])]
        if not same:
            return re.escape(line[:size])
    return f"{re.escape(line)}\\s*$"  # samples go on where it ends


def _time(
    made: Draft,
    guess: Guess | None,
    columns: Mapping[str, FloatArray],
    layout: TextLayout | None,
) -> None:
    add = made.lines.append
    add("\n[time]")
    if guess is None:
        add(f'sampling = "{FILL_IN}"  # no column says when; at which rate were samples taken?')
        made.ask('the sampling rate, as sampling = "1 kHz" under [time]')
        return
    add(f"column = {name_of(guess)}  # {guess.why}")
    values = columns.get(str(guess.column))
    if values is None:
        _dates(made, guess, layout)
        return
    unit = guess.unit if guess.unit not in ("", "counts") else FILL_IN
    add(f'unit = "{unit}"')
    steps = np.diff(values[np.isfinite(values)])
    step = float(np.median(steps)) if steps.size else 0.0
    if unit == FILL_IN:
        made.ask(f'the unit of time: its steps are {step:.6g} (ms, us, s?), as unit = "ms"')
    if turn := wrapped(values):
        add(f"wrap = {turn:.0f}  # the counter begins anew")
        made.seen.append(f"a clock that begins anew after {turn:.0f}")
    if values.size and abs(float(values[0])) > 0.0:
        add("from_zero = true")
    if steps.size and np.mean(steps == 0.0) > COARSE:
        add(f'order = "{FILL_IN}"  # many rows share a stamp: "mean", or sampling for the column')
        made.ask(f'is "{guess.column}" the clock? Many rows share a stamp of it')
    elif steps.size and (steps <= 0.0).any() and not _begins_anew(values) and not wrapped(values):
        add('order = "mean"  # some stamps are doubled or out of order; or "drop", "sort"')
        made.seen.append(f"{int((steps <= 0.0).sum())} stamps doubled or out of order")
    made.seen.append(f'time in "{guess.column}", steps of {step:.6g} {unit}')
    if unit != FILL_IN and step > 0.0:
        from hannes.core.io.units import unit_scale

        made.seen[-1] += f" ({1.0 / (step * unit_scale(unit, 's')):.4g} Hz)"


def _dates(made: Draft, guess: Guess, layout: TextLayout | None) -> None:
    """The form of stamps, of which only a person knows whether the day or the month is first."""
    cells: list[str] = []
    if layout is not None:
        by_name = str(guess.column) in layout.names
        place = layout.names.index(str(guess.column)) if by_name else int(guess.column) - 1
        cells = [row[place] for row in layout.rows if place < len(row)]
    form = form_of_stamps(cells)
    made.lines.append(f'format = "{form or FILL_IN}"')
    made.seen.append(f'time in "{guess.column}", dates and times')
    if not form:
        made.ask(f'the form of "{guess.column}", such as {cells[0]!r}, as "%d.%m.%Y %H:%M:%S.%f"')
