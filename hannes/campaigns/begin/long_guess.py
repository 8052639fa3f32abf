"""Whether a file is a long table: a row a value, with the name of its signal in a column."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from hannes.campaigns.begin.column_guess import Guess, Seen, guesses, split_name
from hannes.campaigns.begin.text_layout import TextLayout
from hannes.campaigns.foreign.binary_columns import Arrays
from hannes.campaigns.foreign.long_table import Wide
from hannes.campaigns.foreign.mapping import Column, LongRule, TextRule, TimeRule
from hannes.campaigns.foreign.mapping_clock import DELIMITERS
from hannes.campaigns.foreign.text_codes import Texts
from hannes.campaigns.foreign.text_columns import Delimited
from hannes.core.errors import BadInput

NAMES = (
    "signal", "name", "channel", "variable", "measurement", "field", "topic", "key", "tag",
    "metric", "parameter", "quantity", "item", "kanal", "segnale", "canale", "nome", "canal", "nom",
)  # fmt: skip
VALUES = ("value", "val", "wert", "messwert", "valore", "valeur", "valor", "reading")
UNITS = ("unit", "units", "einheit", "unita", "unite", "unidad")
FEWEST = 3  # rows a signal


@dataclass(frozen=True)
class LongSeen:
    """A long table: the line of the mapping that says so, and its signals as columns."""

    line: str
    columns: list[Seen]


def long_columns(
    path: Path, layout: TextLayout | None, source: object, seen: Sequence[Seen]
) -> LongSeen | None:
    """Look for columns of names and of values; None where there are none."""
    values = _named([str(each.column) for each in seen if each.values is not None], VALUES)
    clock = next((each for each in guesses(seen, ()) if each.channel == "time"), None)
    if not values or clock is None:
        return None
    whole = _reader(path, layout) if layout is not None else source
    if not isinstance(whole, Arrays | Delimited):
        return None
    names = whole.text_names if isinstance(whole, Arrays) else tuple(whole.names)
    name = _named(names, NAMES)
    if not name or not (texts := _texts(whole, name)) or len(texts.names) < 2:
        return None
    if texts.codes.size < FEWEST * len(texts.names):
        return None
    rule = LongRule(Column(name), Column(values))
    ticks = next(each for each in seen if each.column == clock.column)
    wide = Wide(whole, rule, _clock(clock, ticks), None)
    units = _units(whole, _named(names, UNITS), texts)
    line = f'long = {{ names = "{name}", values = "{values}" }}'
    return LongSeen(line, _columns(wide, ticks, units))


def _columns(wide: Wide, ticks: Seen, units: Mapping[str, str]) -> list[Seen]:
    column = Column(ticks.column)
    times = Seen(ticks.column, ticks.name, ticks.unit, wide.numbers(column))
    if ticks.values is None:
        times = ticks
    return [times, *(Seen(n, n, units.get(n, ""), wide.numbers(Column(n))) for n in wide.names)]


def _reader(path: Path, layout: TextLayout) -> Delimited:
    rule = TextRule(
        DELIMITERS.get(layout.delimiter, layout.delimiter),
        layout.decimal,
        layout.comment,
        layout.header,
        layout.first,
        layout.encoding,
        ragged=layout.ragged,
    )
    return Delimited(path, rule, layout.missing)


def _clock(clock: Guess, ticks: Seen) -> TimeRule:
    return TimeRule(Column(clock.column), iso=ticks.values is None)


def _named(names: Sequence[str], words: Sequence[str]) -> str:
    """The one name of which a word is among `words`, "" where there is none, or several."""
    found = [name for name in names if set(split_name(name)[0]) & set(words)]
    return found[0] if len(found) == 1 else ""


def _texts(source: Arrays | Delimited, name: str) -> Texts | None:
    try:
        return source.texts(Column(name))
    except BadInput:
        return None


def _units(source: Arrays | Delimited, column: str, names: Texts) -> dict[str, str]:
    """Units by signal, of those that have one unit throughout."""
    units = _texts(source, column) if column else None
    if units is None:
        return {}
    found = {}
    for place, name in enumerate(names.names):
        own = np.unique(units.codes[names.codes == place])
        if own.size == 1 and own[0] >= 0:
            found[name] = units.names[own[0]]
    return found
