"""A data set's specification: TOML into groups of grasps whose quantities vary."""

import fnmatch
import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any

from hannes.contact.shapes import SHAPES
from hannes.core.errors import BadInput, nearest
from hannes.core.io.inputs import noted
from hannes.core.io.toml_table import Table, read_text
from hannes.core.io.units import quantity
from hannes.core.model import differences
from hannes.core.trust.consent import consenting
from hannes.dataset.distributions import Distribution, read_distribution
from hannes.dataset.empty_closure import read_empty
from hannes.simulation.experiment import shipped
from hannes.simulation.experiment.experiment import CONTROLLERS, Experiment, Reference
from hannes.simulation.experiment.reader import MOST_SAMPLES, NOISE, read_reference
from hannes.simulation.hand.hand import Hand
from hannes.simulation.hand.hand_file import (
    changed,
    declared,
    effect_names,
    load_hand,
    texts,
)

KEYS = (
    "title", "hand", "effects", "parameters", "seed", "duration", "sampling", "controller",
    "rtol", "border", "channels", "reference", "empty", "values", "grasps",
)  # fmt: skip
GROUP = ("name", "shape", "role", "draws", "values")
ROLES = ("train", "test", "pressed")
CHANNELS = ("reference", "position", "current", "force")
MOST_GRASPS = 10_000_000
BORDER = "5.5 kN/m"  # about the geometric mean of the shipped dynamometer and of the soft ball
TOUCH_SEEN, TOUCH_DELAY = "command.touch_seen", "command.touch_delay"
# Quantities of a grasp besides parameters of hand and object: unit, bounds, default value.
OWN: dict[str, tuple[str, float, float, float]] = {
    "command.speed": ("1", 0.05, 5.0, 1.0),
    "command.amplitude": ("1", 0.05, 2.0, 1.0),
    "command.knee": ("rad", -100.0, 100.0, 100.0),
    "command.share": ("1", 0.0, 1.0, 1.0),
    "command.touch_share": ("1", 0.0, 1.0, 1.0),
    "command.press_share": ("1", 0.0, 1.0, 0.0),
    TOUCH_DELAY: ("s", 0.0, 1.0, 0.0),
    TOUCH_SEEN: ("1", 0.0, 1.0, 0.0),
    **{f"noise.{name}": (unit, 0.0, 1e3, 0.0) for name, unit in NOISE.items()},
    **{f"resolution.{name}": (unit, 0.0, 1e3, 0.0) for name, unit in NOISE.items()},
}


@dataclass(frozen=True)
class Group:
    """Grasps of one shape (None: empty hand): every cell of its levels, `draws` times.

    `distributions` are in alphabetical order, which random numbers and the order of cells follow.
    """

    name: str
    shape: str | None
    role: str
    draws: int
    distributions: Mapping[str, Distribution]

    @property
    def cells(self) -> int:
        """Number of combinations of levels."""
        return math.prod(len(each.levels) for each in self.distributions.values())

    @property
    def count(self) -> int:
        """Number of grasps."""
        return self.cells * self.draws

    def levels(self, cell: int) -> dict[str, int]:
        """Which level each quantity has in a cell; the last varies fastest."""
        found = {}
        for name, distribution in reversed(list(self.distributions.items())):
            cell, found[name] = divmod(cell, len(distribution.levels))
        return found


@dataclass(frozen=True)
class Spec:
    """All grasps of a data set; `text` is the specification resolved, without other files.

    `inputs` are the files that it was read from, which no result may replace. `empty`: the command
    by which each hand of a pressed grasp closes on nothing, too; None where none does.
    """

    title: str
    text: str
    hand: Hand
    base: Experiment
    seed: int
    rtol: float
    border: float
    channels: tuple[str, ...]
    groups: tuple[Group, ...]
    empty: Reference | None = None
    inputs: frozenset[Path] = field(default=frozenset(), repr=False, compare=False)

    @property
    def count(self) -> int:
        """Number of grasps."""
        return sum(group.count for group in self.groups)

    @cached_property
    def columns(self) -> tuple[str, ...]:
        """Full names of all quantities that vary, and the object's stiffness."""
        names = {name: None for group in self.groups for name in group.distributions}
        return tuple(sorted(names | {"object.stiffness": None}))

    def unit(self, column: str) -> str:
        """Unit of a column."""
        return OWN[column][0] if column in OWN else self.hand.parameters.require(column).unit

    def place(self, number: int) -> tuple[int, int]:
        """Group of a grasp, and its number within it; BadInput where there is no such grasp."""
        left = number
        for k, group in enumerate(self.groups):
            if 0 <= left < group.count:
                return k, left
            left -= group.count
        raise BadInput(f"no grasp {number}: the data set has {self.count}, counted from 0")


def load_spec(name: str | Path, *, trust: bool = False) -> Spec:
    """Read a shipped specification by name, or a .toml file; BadInput otherwise.

    `trust`: Python that the file names may run.
    """
    path = find(name)
    with noted() as inputs, consenting(trust):
        made = read_spec(read_text(path), str(name), path.parent)
        return replace(made, inputs=frozenset(inputs))


def find(name: str | Path) -> Path:
    """File of a specification."""
    if str(name).endswith(".toml"):
        return Path(name)
    folder = shipped.folder() / "datasets"
    names = sorted(path.stem for path in folder.glob("*.toml"))
    if str(name) not in names:
        raise BadInput(
            f'no data set named "{name}"{nearest(str(name), names)} '
            f"(shipped: {', '.join(names)}; or give the path of a .toml file)"
        )
    return folder / f"{name}.toml"


def read_spec(text: str, where: str = "data set", folder: Path | None = None) -> Spec:
    """Return the specification in a TOML text; relative paths start at `folder`.

    `where` names the text in messages. Raises BadInput naming file and key.
    """
    root = Table.parse(text, where, KEYS)
    hand = changed(load_hand(root.text("hand", "hannes"), folder), root, folder)
    base = _base(root, folder)
    common = _distributions(root.table("values"), hand)
    groups = tuple(_group(root, k, hand, common) for k in range(len(_tables(root))))
    if not 1 <= sum(group.count for group in groups) <= MOST_GRASPS:
        root.refuse("grasps", f"expected from 1 to {MOST_GRASPS} grasps in all")
    if len({group.name for group in groups}) < len(groups):
        root.refuse("grasps", "has two groups of one name; name them apart")
    return Spec(
        root.text("title", Path(where).stem),
        _resolved(root, hand, base),
        hand,
        base,
        root.whole("seed", 0, 2**32 - 1, 0),
        _rtol(root),
        root.quantity("border", "N/m") if "border" in root else quantity(BORDER, "N/m", "border"),
        _channels(root),
        groups,
        read_empty(root, folder, base.sampling),
    )


def _base(root: Table, folder: Path | None) -> Experiment:
    """What all grasps share."""
    duration = root.quantity("duration", "s", "1.15 s")
    sampling = root.quantity("sampling", "Hz") if "sampling" in root else 1000.0
    if not (duration > 0.0 and sampling > 0.0 and 2 <= duration * sampling <= MOST_SAMPLES):
        root.refuse("duration", f"and sampling: expected 2 to {MOST_SAMPLES} samples a grasp")
    controller = root.choice("controller", CONTROLLERS, "continuous")
    reference = read_reference(root, folder)
    return Experiment("", duration, reference, sampling=sampling, controller=controller)


def _rtol(root: Table) -> float:
    given = root.content.get("rtol", 1e-3)
    if not isinstance(given, float) or not 1e-8 <= given <= 1e-2:
        root.refuse("rtol", "must be a number from 1e-8 to 1e-2, without quotes")
    return given


def _channels(root: Table) -> tuple[str, ...]:
    chosen = tuple(root.texts("channels")) or CHANNELS
    for name in chosen:
        if name not in (*NOISE, "reference"):
            known = ", ".join((*NOISE, "reference"))
            root.refuse("channels", f'has "{name[:40]}": expected some of {known}')
    return tuple(dict.fromkeys(chosen))


def _tables(root: Table) -> list[Any]:
    root.require("grasps", '[{ name = "balls", shape = "sphere", draws = 100 }]')
    return root.items("grasps")


def _group(root: Table, k: int, hand: Hand, common: Mapping[str, Distribution]) -> Group:
    given = _tables(root)[k]
    if not isinstance(given, dict):
        root.refuse("grasps", "must be tables: lines [[grasps]], keys below each")
    table = Table(given, root.where, GROUP, f"grasps[{k}].")
    shape = table.choice("shape", (*SHAPES, "none"))
    varied = {**common, **_distributions(table.table("values"), hand)}
    _require_one_touch(table, varied)
    return Group(
        table.text("name", f"group {k + 1}"),
        None if shape == "none" else shape,
        table.choice("role", ROLES, "train"),
        table.whole("draws", 1, MOST_GRASPS, 1),
        dict(sorted(varied.items())),
    )


def _require_one_touch(table: Table, varied: Mapping[str, Distribution]) -> None:
    """Refuse a touch that the sensors show in part, or that comes after a delay too."""
    seen = varied.get(TOUCH_SEEN, Distribution())
    if seen.kind or not {0.0, 1.0}.issuperset(seen.levels):
        table.refuse("values", f'have "{TOUCH_SEEN}", which is "0" or "1"')
    if 1.0 in seen.levels and TOUCH_DELAY in varied:
        table.refuse(
            "values",
            f'have "{TOUCH_SEEN}" of 1 and "{TOUCH_DELAY}": what the sensors show comes when it '
            "does; leave one out",
        )


def _distributions(table: Table, hand: Hand) -> dict[str, Distribution]:
    """Distributions by full name; a name with * matches all parameters that are not zero.

    A full name overrides a pattern, a longer pattern a shorter one.
    """
    distributions: dict[str, Distribution] = {}
    for key in sorted(table.content, key=lambda key: ("*" not in key, len(key), key)):
        if "*" not in key:
            distributions[key] = _distribution(table, key, key, hand)
            continue
        names = [name for name, x in hand.parameters.items() if x and fnmatch.fnmatch(name, key)]
        if not names:
            table.refuse(key, "stands for no parameter that is not zero")
        distributions |= {name: _distribution(table, key, name, hand) for name in names}
    return distributions


def _distribution(table: Table, key: str, name: str, hand: Hand) -> Distribution:
    if name not in OWN and name.partition(".")[0] in ("command", "noise", "resolution"):
        table.refuse(key, f"is unknown{nearest(name, OWN)} (there are {', '.join(OWN)})")
    if name not in OWN:
        parameter = declared(name, hand, table)
        return read_distribution(table, key, parameter.unit, parameter.check)
    unit, low, high, _ = OWN[name]

    def check(value: float) -> float:
        if not low <= value <= high:
            table.refuse(key, f"= {value:g}: expected from {low:g} to {high:g} [{unit}]")
        return value

    return read_distribution(table, key, unit, check)


def _resolved(root: Table, hand: Hand, base: Experiment) -> str:
    """The specification as TOML that needs no other file."""
    import tomli_w

    content = {**root.content, "hand": "hannes", "effects": effect_names(hand)}
    content["parameters"] = texts(hand, differences(hand))
    if not base.reference.kinked:
        content["reference"] = {"kind": "file", "points": _points(base.reference)}
    return tomli_w.dumps(content)


def _points(reference: Reference) -> list[list[str]]:
    return [[f"{t!r} s", f"{x!r} rad"] for t, x in reference.knots.T.tolist()]
