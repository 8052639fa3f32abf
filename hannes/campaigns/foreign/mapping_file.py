"""Reads a mapping's TOML; every error names the file, the key and what was expected there."""

from pathlib import Path
from typing import Any

from hannes.campaigns.foreign.mapping import (
    FILLS,
    TARGETS,
    YARDSTICKS,
    AlignRule,
    ChannelRule,
    Column,
    ColumnMap,
    TextRule,
    TimeRule,
)
from hannes.core.errors import BadInput, nearest
from hannes.core.io import units
from hannes.core.io.toml_table import Table, read_text
from hannes.core.io.units import quantity
from hannes.plants.protocol import Plant, expectations, find_plant

KEYS = ("plant", "experiment", "missing", "split", "text", "time", "channels", "align")
TEXT = ("delimiter", "decimal", "comment", "header", "first", "encoding")
TIME = ("column", "index", "unit", "format", "sampling", "offset", "from_zero", "resample")
CHANNEL = ("column", "index", "unit", "scale", "reversed", "side", "ratio", "offset", "fill")
ALIGN = ("to", "by", "channel", "within", "lag")
DELIMITERS = {"comma": ",", "semicolon": ";", "tab": "\t", "space": " "}
ENCODINGS = ("utf-8", "latin-1", "utf-16")
SIDES = ("output", "motor")
RATIO = "gear.ratio"  # parameter of a plant that has a reducer
MOST_LINES = 10**9
FASTEST = 1e7  # Hz


def read_mapping(path: str | Path) -> ColumnMap:
    """Read a mapping; BadInput with file, key and what to do for whatever cannot be used."""
    path = Path(path)
    root = Table.parse(read_text(path), str(path), KEYS)
    name = root.text("plant", "hand")
    try:
        plant = find_plant(name, path.parent)
    except BadInput as error:
        root.refuse("plant", f'= "{name[:60]}" cannot be used: {error}')
    return ColumnMap(
        plant,
        _channels(root, plant),
        _time(root),
        _text(root),
        _missing(root),
        _place(root, "split") if "split" in root else None,
        _experiment(root, path.parent),
        _align(root, plant) if "align" in root else None,
    )


def _channels(root: Table, plant: Plant) -> dict[str, ChannelRule]:
    root.require("channels", "[channels.position] with column and unit below it")
    known = tuple(name for name in plant.channels if name != "time")
    table = root.table("channels", known)
    if not table.content:
        root.refuse("channels", f"is empty: expected one or more of {', '.join(known)}")
    return {name: _channel(table.table(name, CHANNEL), plant, name) for name in table.content}


def _channel(table: Table, plant: Plant, name: str) -> ChannelRule:
    wanted = plant.channels[name]
    factor = _factor(table, wanted)
    factor *= quantity(table.content.get("scale", 1), "1", table.name("scale"))
    factor /= _ratio(table, plant, wanted)
    if factor == 0.0:
        table.refuse("scale", "is zero: nothing would be left of the channel")
    offset = table.quantity("offset", wanted) if "offset" in table else 0.0
    fill = table.choice("fill", FILLS, "drop")
    return ChannelRule(_column(table), -factor if table.flag("reversed") else factor, offset, fill)


def _factor(table: Table, wanted: str) -> float:
    """Worth of the column's unit in the unit that the plant declares."""
    table.require("unit", f'"{wanted}"')
    given = table.text("unit", "")
    try:
        return units.unit_scale(given, wanted)
    except BadInput as error:
        table.refuse("unit", f'= "{given[:60]}" cannot be used: {error}')


def _ratio(table: Table, plant: Plant, wanted: str) -> float:
    """Motor turns per turn of the output shaft where the column is of the motor's side, else 1."""
    if table.choice("side", SIDES, "output") == "output":
        if "ratio" in table:
            table.refuse("ratio", 'belongs to side = "motor"')
        return 1.0
    if wanted not in ("rad", "rad/s"):
        table.refuse("side", f"is of angles and angular speeds only; this channel is in {wanted}")
    if "ratio" not in table and RATIO not in plant.parameters:
        table.refuse("ratio", f"is missing: the plant {plant.name} declares no {RATIO}")
    ratio = table.quantity("ratio", "1") if "ratio" in table else plant.parameters[RATIO]
    if not ratio > 0.0:
        table.refuse("ratio", f"= {ratio:g}: expected a number above zero")
    return ratio


def _column(table: Table) -> Column:
    table.require("column", '"name of the column", or its number')
    name = _name_or_number(table, "column")
    return Column(name, table.whole("index", 1, MOST_LINES) if "index" in table else 0)


def _name_or_number(table: Table, key: str) -> str | int:
    name = table.content[key]
    if isinstance(name, int) and not isinstance(name, bool) and name >= 1:
        return name
    if not isinstance(name, str) or not name:
        table.refuse(key, "must be the name of a column in quotes, or its number from 1")
    return name


def _place(root: Table, key: str) -> Column:
    return Column(_name_or_number(root, key))


def _time(root: Table) -> TimeRule:
    root.require("time", '{ column = "t", unit = "s" }, or { sampling = "1 kHz" }')
    table = root.table("time", TIME)
    if ("column" in table) == ("sampling" in table):
        table.refuse("column", "or sampling: expected one of the two, the clock of the recording")
    for key in ("index", "unit", "format", "from_zero"):
        if "sampling" in table and key in table:
            table.refuse(key, "belongs to a time column, not to a sampling rate")
    iso = table.choice("format", ("number", "iso"), "number") == "iso"
    if iso and "unit" in table:
        table.refuse("unit", 'does not go with format = "iso": such stamps carry their unit')
    return TimeRule(
        _column(table) if "column" in table else None,
        1.0 if iso or "sampling" in table else _factor(table, "s"),
        _rate(table, "sampling"),
        iso,
        iso or table.flag("from_zero"),
        table.quantity("offset", "s") if "offset" in table else 0.0,
        _rate(table, "resample"),
    )


def _rate(table: Table, key: str) -> float:
    """Return a sampling rate [Hz], 0 where the key is absent."""
    if key not in table:
        return 0.0
    rate = table.quantity(key, "Hz", "1 kHz")
    if not 0.0 < rate <= FASTEST:
        table.refuse(key, f"= {rate:g} Hz: expected more than 0 and at most {FASTEST:g} Hz")
    return rate


def _text(root: Table) -> TextRule:
    table = root.table("text", TEXT)
    header = table.whole("header", 0, MOST_LINES, 1)
    first = table.whole("first", 1, MOST_LINES, header + 1)
    if first <= header:
        table.refuse("first", f"= {first}: numbers start below the header in line {header}")
    decimal = table.choice("decimal", (".", ","), ".")
    delimiter = _delimiter(table)
    if decimal == delimiter == ",":
        table.refuse("decimal", "and delimiter are both a comma: nothing distinguishes them")
    encoding = table.choice("encoding", ENCODINGS, "utf-8")
    return TextRule(delimiter, decimal, table.text("comment", ""), header, first, encoding)


def _delimiter(table: Table) -> str:
    given = table.content.get("delimiter", "")
    if not isinstance(given, str):
        table.refuse("delimiter", f"must be in quotes: one character, or {', '.join(DELIMITERS)}")
    found = DELIMITERS.get(given, given)
    if len(found) > 1 or found in ('"', "\n", "\r"):
        hint = nearest(given, DELIMITERS)
        table.refuse("delimiter", f"must be one character, or {', '.join(DELIMITERS)}{hint}")
    return found


def _missing(root: Table) -> tuple[str, ...]:
    values: list[Any] = root.items("missing")
    if not all(isinstance(v, str | int | float) and not isinstance(v, bool) for v in values):
        root.refuse("missing", 'must be a list of texts or numbers, such as ["-999", "n/a"]')
    return tuple(str(value).strip() for value in values)


def _experiment(root: Table, folder: Path) -> str:
    """Text of the experiment under which the recording was made, or nothing."""
    from hannes.simulation.experiment.reader import experiment_text, parse_experiment

    name = root.text("experiment", "")
    if not name:
        return ""
    try:
        text = experiment_text(name, folder)
        parse_experiment(text, name)
    except BadInput as error:
        root.refuse("experiment", f'= "{name}" cannot be used: {error}')
    return text


def _align(root: Table, plant: Plant) -> AlignRule:
    table = root.table("align", ALIGN)
    to, by = table.choice("to", TARGETS), table.choice("by", YARDSTICKS, "simulation")
    channel = table.text("channel", _follower(table, plant))
    if channel not in root.table("channels").content:
        table.refuse("channel", f'= "{channel}": no such channel is mapped, nothing to see it by')
    if to == "reference" and "reference" not in root.table("channels").content:
        table.refuse("to", '= "reference": no channel reference is mapped')
    if to == "experiment" and "experiment" not in root:
        table.refuse("to", '= "experiment": the mapping names no experiment')
    if "lag" in table and by == "simulation":
        table.refuse("lag", 'belongs to by = "command": a simulation has its own')
    within = table.quantity("within", "s") if "within" in table else 1.0
    if not 0.0 < within <= 3600.0:
        table.refuse("within", f"= {within:g} s: expected more than 0 and at most 3600 s")
    lag = table.quantity("lag", "s") if "lag" in table else 0.0
    return AlignRule(to, by, channel, within, lag)


def _follower(table: Table, plant: Plant) -> str:
    """The channel that the plant says follows its reference."""
    found = [name for name, each in expectations(plant).items() if each.follows == "reference"]
    if not found and "channel" not in table:
        table.refuse("channel", f"is missing: {plant.name} does not say what follows its reference")
    return found[0] if found else ""
