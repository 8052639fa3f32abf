"""The settings of a calibration: the table [calibrate] of a campaign, with defaults."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from hannes.campaigns.quality.finding import KINDS
from hannes.core.errors import BadInput, nearest
from hannes.core.io.toml_table import Table
from hannes.core.io.units import quantity
from hannes.core.parameter import Parameter
from hannes.identification.calibration.rest import Rest
from hannes.identification.calibration.tuning import CALIBRATION
from hannes.identification.grasp_features import FEATURES
from hannes.plants.protocol import Plant, run_to_run_spread

KEYS = (
    *("parameters", "spread", "bounds", "nuisance", "doubt", "doubt_apart", "channels"),
    *("features", "loss", "starts", "scan", "model_error", "limit", "accept"),
)
LOSSES = ("linear", "soft_l1", "huber", "cauchy")
MOST_STARTS, MOST_SCANNED = 64, 4096


@dataclass(frozen=True)
class Plan:
    """A calibration to be made; all sizes in SI.

    names:       parameters to fit
    named:       whether the campaign named them, or the plant's usual ones are taken
    spread:      parameter -> standard deviation of its nominal value
    bounds:      parameter -> lowest and highest value
    nuisance:    parameter -> standard deviation from run to run
    start_time:  standard deviation [s] of the moment at which a run starts, 0 where it is known
    doubt:       uncertain parameters that are not fitted -> standard deviation; empty where these
                 are taken as exact
    parts:       what single parts may be off for themselves (each joint, each object of an
                 experiment) -> standard deviation, relative
    rest:        what of `doubt` and `parts` was stated, and what is the default
    channels:    compared as traces;  features: compared as figures (see grasp_features.py)
    loss:        of scipy's least_squares
    starts:      number of starting points;  scan: number of points scanned to find them
    model_error: share of a channel's RMS that is taken as model error
    limit:       relative half-width of an interval beyond which a parameter is not identified
    usual:       parameter -> standard deviation of given values, as stated or as of the rest
    accept:      kinds of data issues that are accepted
    controller:  that another one was taken than the experiments say, or ""
    """

    names: tuple[str, ...]
    named: bool
    spread: Mapping[str, float]
    bounds: Mapping[str, tuple[float, float]]
    nuisance: Mapping[str, float]
    start_time: float = 0.0
    doubt: Mapping[str, float] = field(default_factory=dict)
    parts: Mapping[str, float] = field(default_factory=dict)
    rest: Rest = field(default_factory=Rest)
    channels: tuple[str, ...] = ()
    features: tuple[str, ...] = ()
    loss: str = "linear"
    starts: int = 4
    scan: int = 0
    model_error: float = 0.01
    limit: float = 0.1
    seed: int = 0
    scale: Mapping[str, float] = field(default_factory=dict)
    accept: tuple[str, ...] = ()
    usual: Mapping[str, float] = field(default_factory=dict)
    controller: str = ""

    @property
    def uncertain(self) -> dict[str, float]:
        """All that is uncertain and not fitted: parameters, then single parts."""
        return {**self.doubt, **self.parts}


def read_plan(table: Table, plant: Plant, channels: Iterable[str], seed: int = 0) -> Plan:
    """Return the plan of a table [calibrate] for recordings that have these `channels`.

    Raises BadInput for an unknown name, a wrong unit, a value out of bounds.
    """
    there = [name for name in plant.judged if name in set(channels)]
    names = _names(table, plant)
    rest = Rest.read(table, plant)
    features = tuple(_known(table, "features", FEATURES))
    declared = {name: plant.parameters.declared[name] for name in names}
    spread = {name: _weak(plant.parameters[name], each) for name, each in declared.items()}
    stated = _sizes(table.table("spread"), plant, names)
    return Plan(
        names,
        "parameters" in table,
        {**spread, **stated},
        {**{n: e.bounds for n, e in declared.items()}, **_bounds(table.table("bounds"), declared)},
        _nuisances(table.table("nuisance"), plant),
        _start_time(table.table("nuisance"), plant),
        rest.doubt(plant, names),
        {},
        rest,
        tuple(_known(table, "channels", there)) if "channels" in table else tuple(there),
        features,
        table.choice("loss", LOSSES, "linear"),
        table.whole("starts", 1, MOST_STARTS, 4),
        table.whole("scan", 0, MOST_SCANNED, CALIBRATION.scanned_points if features else 0),
        _share(table, "model_error", 0.01),
        _share(table, "limit", 0.1),
        seed,
        {name: abs(plant.parameters[name]) or spread[name] for name in names},
        tuple(_known(table, "accept", KINDS)),
        {**{n: x for n, x in rest.doubt(plant, ()).items() if n in names}, **stated},
    )


def _names(table: Table, plant: Plant) -> tuple[str, ...]:
    """The parameters that are asked for, or the usual ones of the plant and its effects."""
    if "parameters" not in table:
        own = (e.full_name(p.name) for e in plant.effects for p in e.parameters)
        return tuple(dict.fromkeys([*plant.free, *own]))
    names = table.texts("parameters")
    for name in names:
        _require(table, "parameters", name, plant)
    if not names or len(set(names)) < len(names):
        table.refuse("parameters", "names none" if not names else "names one twice")
    return tuple(names)


def _require(table: Table, key: str, name: str, plant: Plant) -> Parameter:
    try:
        return plant.parameters.require(name)
    except BadInput as error:
        table.refuse(key, f"cannot be used: {error}")


def _weak(value: float, declared: Parameter) -> float:
    low, high = declared.bounds
    return CALIBRATION.weak_prior * abs(value) or (high - low) / 20.0


def _sizes(table: Table, plant: Plant, names: Iterable[str]) -> dict[str, float]:
    """Standard deviations by parameter, with unit or in percent of the nominal value."""
    for name in table.content:
        if name not in names:
            table.refuse(name, f"is no parameter of this calibration{nearest(name, names)}")
    return {name: _size(table, name, plant) for name in table.content}


def _size(table: Table, name: str, plant: Plant) -> float:
    given, value = table.content[name], plant.parameters[name]
    unit = _require(table, name, name, plant).unit
    if isinstance(given, str) and given.rstrip().endswith("%"):
        size = quantity(given, "1", table.name(name)) * abs(value)
    else:
        size = quantity(given, unit, table.name(name))
    if not size > 0.0:
        table.refuse(name, f"= {given}: expected a standard deviation above zero")
    return size


def _nuisances(table: Table, plant: Plant) -> dict[str, float]:
    """Run-to-run variability: the campaign's, else the plant's own."""
    usual = {name: size for name, size in run_to_run_spread(plant).items() if size > 0.0}
    own = [name for name in table.content if name != "start_time"]
    return {name: _size(table, name, plant) for name in own} if own else usual


def _start_time(table: Table, plant: Plant) -> float:
    """Standard deviation [s]: the campaign's, else the plant's own."""
    if "start_time" not in table:
        return float(getattr(plant, "start_time", 0.0))
    spread = table.quantity("start_time", "s")
    if spread < 0.0:
        table.refuse("start_time", f"= {spread:g} s: a standard deviation is not negative")
    return spread


def _bounds(table: Table, declared: Mapping[str, Parameter]) -> dict[str, tuple[float, float]]:
    found = {}
    for name in table.content:
        if name not in declared:
            table.refuse(name, f"is no parameter of this calibration{nearest(name, declared)}")
        pair = [quantity(x, declared[name].unit, table.name(name)) for x in table.items(name, 2)]
        lowest, highest = declared[name].bounds
        if not lowest <= pair[0] < pair[1] <= highest:
            table.refuse(name, f"= {pair}: expected two rising values from {lowest} to {highest}")
        found[name] = (pair[0], pair[1])
    return found


def _known(table: Table, key: str, names: Iterable[str]) -> list[str]:
    known, asked = list(names), table.texts(key)
    for name in asked:
        if name not in known:
            table.refuse(key, f'= "{name}"{nearest(name, known)} (there are {", ".join(known)})')
    return asked


def _share(table: Table, key: str, default: float) -> float:
    share = table.quantity(key, "1") if key in table else default
    if not 0.0 < share < 1.0:
        table.refuse(key, f"= {share:g}: expected a share between 0 and 100 %")
    return share
