"""Reads a mapping's TOML; every error names the file, the key and what was expected there."""

from pathlib import Path
from typing import Any

from hannes.campaigns.foreign.mapping import (
    CURRENTS,
    FILLS,
    SPLITS,
    TARGETS,
    YARDSTICKS,
    AlignRule,
    ChannelRule,
    Column,
    ColumnMap,
    LongRule,
)
from hannes.campaigns.foreign.mapping_clock import (
    TIME,
    above_zero,
    column_of,
    further_files,
    name_or_number,
    text_rule,
    time_rule,
    unit_factor,
)
from hannes.core.errors import BadInput
from hannes.core.io.toml_table import Table, read_text
from hannes.core.io.units import quantity
from hannes.core.trust.consent import consenting
from hannes.plants.protocol import Plant, expectations, find_plant
from hannes.simulation.experiment import shipped

KEYS = (
    "plant", "experiment", "missing", "split", "split_at", "text", "time", "channels", "align",
    "files", "long",
)  # fmt: skip
CHANNEL = (
    "column", "index", "unit", "scale", "reversed", "side", "ratio", "offset", "fill",
    "signed", "unwrap", "kind", "constant", "from", "renewed",
)  # fmt: skip
ALIGN = ("to", "by", "channel", "within", "lag")
STATED = ("unit", "scale", "reversed", "side")
SIDES = ("output", "motor")
RATIO = "gear.ratio"  # parameter of a plant that has a reducer


def read_mapping(path: str | Path, *, trust: bool = False) -> ColumnMap:
    """Read a mapping, a TOML file or a shipped name such as `rh56`.

    `trust`: Python that it names may run. BadInput with file, key and what to do for whatever
    cannot be used.
    """
    with consenting(trust):
        return _mapping(mapping_file(path))


def mapping_file(name: str | Path) -> Path:
    """Return the file of a mapping: a path, which ends in .toml, or a shipped name."""
    folder = shipped.folder() / "mappings"
    names = {each.stem for each in folder.glob("*.toml")}
    return folder / f"{name}.toml" if str(name) in names else Path(name)


def _mapping(path: Path) -> ColumnMap:
    root = Table.parse(read_text(path), str(path), KEYS)
    name = root.text("plant", "hand")
    try:
        plant = find_plant(name, path.parent, path)
    except BadInput as error:
        root.refuse("plant", f'= "{name[:60]}" cannot be used: {error}')
    return ColumnMap(
        plant,
        _channels(root, plant),
        time_rule(root),
        text_rule(root),
        _missing(root),
        _split(root),
        _experiment(root, path.parent),
        _align(root, plant) if "align" in root else None,
        root.choice("split_at", SPLITS) if "split_at" in root else "",
        further_files(root),
        _long(root) if "long" in root else None,
    )


def _channels(root: Table, plant: Plant) -> dict[str, ChannelRule]:
    root.require("channels", "[channels.position] with column and unit below it")
    known = tuple(name for name in plant.channels if name != "time")
    table = root.table("channels", known)
    if not table.content:
        root.refuse("channels", f"is empty: expected one or more of {', '.join(known)}")
    rules = {name: _channel(table.table(name, CHANNEL), plant, name) for name in table.content}
    if any(rule.supply for rule in rules.values()) and "duty" not in rules:
        table.refuse("duty", "is missing: a supply's current is divided by it")
    if all(rule.column is None or rule.source for rule in rules.values()):
        root.refuse("channels", "name no column of the first file")
    return rules


def _channel(table: Table, plant: Plant, name: str) -> ChannelRule:
    wanted = plant.channels[name]
    if "constant" in table:
        return _constant(table, wanted)
    factor = unit_factor(table, wanted)
    factor *= quantity(table.content.get("scale", 1), "1", table.name("scale"))
    factor /= _ratio(table, plant, wanted)
    if factor == 0.0:
        table.refuse("scale", "is zero: nothing would be left of the channel")
    supply = table.choice("kind", CURRENTS, "motor") == "supply"
    if supply and wanted != "A":
        table.refuse("kind", f'= "supply" is of currents only; this channel is in {wanted}')
    return ChannelRule(
        column_of(table),
        -factor if table.flag("reversed") else factor,
        table.quantity("offset", wanted) if "offset" in table else 0.0,
        table.choice("fill", FILLS, "linear" if supply else "drop"),
        table.whole("signed", 2, 64) if "signed" in table else 0,
        above_zero(table, "unwrap") if "unwrap" in table else 0.0,
        supply,
        source=table.text("from", ""),
        renewed=table.whole("renewed", 2, 10**6) if "renewed" in table else 0,
        stated=_stated(table),
    )


def _stated(table: Table) -> dict[str, Any]:
    """What a mapping says of a channel's size and sign: further changes are made to that."""
    known = {key: table.content[key] for key in STATED if key in table}
    if "scale" in known:
        known["scale"] = quantity(known["scale"], "1", table.name("scale"))
    return {key: x for key, x in known.items() if isinstance(x, str | float | bool)}


def _constant(table: Table, wanted: str) -> ChannelRule:
    """A channel that no column has: the same value throughout."""
    if others := sorted(set(table.content) - {"constant"}):
        table.refuse(others[0], "does not go with constant, which stands alone")
    return ChannelRule(None, constant=table.quantity("constant", wanted))


def _long(root: Table) -> LongRule:
    """Columns of a long table."""
    table = root.table("long", ("names", "values"))
    for key, example in (("names", "signal"), ("values", "value")):
        table.require(key, f'"{example}"')
    if "sampling" in root.table("time", TIME):
        root.refuse("long", "needs time.column: its rows say when each value was")
    return LongRule(*(Column(name_or_number(table, key)) for key in ("names", "values")))


def _split(root: Table) -> Column | None:
    if "split" in root and "split_at" in root:
        root.refuse("split", "and split_at: expected one of the two")
    return Column(name_or_number(root, "split")) if "split" in root else None


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
