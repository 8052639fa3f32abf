"""The rest of a machine: what a calibration is not asked for, and how inexact that is.

No machine is as its data sheet says. So what is not fitted is uncertain by default, and exactness
must be said. Like parts (the joints of a hand) differ each for itself besides.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from hannes.campaigns.campaign import Entry
from hannes.core.io.toml_table import Table
from hannes.plants.protocol import Plant

SHARE, APART = 0.03, 0.01  # standard deviations by default, relative


@dataclass(frozen=True)
class Rest:
    """How inexact the rest is: relative standard deviations, and whether the campaign states them.

    share: of every value that is not fitted;  apart: of each of several like parts for itself
    """

    share: float = 0.0
    apart: float = 0.0
    stated: bool = False

    @classmethod
    def read(cls, table: Table, plant: Plant) -> "Rest":
        """`doubt` and `doubt_apart` of a table [calibrate]; BadInput where they cannot be used."""
        if not _sizes(plant):
            for key in ("doubt", "doubt_apart"):
                if key in table and _share(table, key):
                    why = f"the plant {plant.name} declares no uncertain parameter"
                    table.refuse(key, f"cannot be used: {why}")
            return cls()
        share = _share(table, "doubt") if "doubt" in table else SHARE
        apart = min(APART, share)
        apart = _share(table, "doubt_apart") if "doubt_apart" in table else apart
        return cls(share, apart, "doubt" in table)

    def doubt(self, plant: Plant, names: Iterable[str]) -> dict[str, float]:
        """Standard deviations [SI] of the parameters that are not in `names`."""
        sizes = {**_sizes(plant), **_of_effects(plant)} if self.share else {}
        return {n: self.share * size for n, size in sizes.items() if n not in names and size}

    def parts(self, plant: Plant, entries: Iterable[Entry]) -> dict[str, float]:
        """Standard deviations of what the plant's parts are off for themselves, relative."""
        parts = getattr(plant, "parts", None)
        if parts is None or not self.share:
            return {}
        found: dict[str, float] = {}
        for entry in entries:
            for name, like in parts(entry.recording).items():
                found[name] = self.apart if like else self.share
        return {name: size for name, size in found.items() if size}

    def sentence(self, doubt: Mapping[str, float], parts: Mapping[str, float]) -> str:
        """What was taken, in words; doubt, parts: of the recordings fitted, see the methods."""
        own = any(name.startswith("object.") for name in parts)
        like = {name.partition(".")[0] for name in parts if not name.startswith("object.")}
        inexact = [f"{len(doubt)} parameters that are not fitted"] * bool(doubt)
        inexact += ["the objects of experiments"] * own
        if not inexact and not like:
            return "all that is not fitted was taken as exact"
        text = f"{' and '.join(inexact) or 'nothing'} were taken as {_percent(self.share)} inexact"
        if like:
            text += f", each of {len(like)} like parts for itself as {_percent(self.apart)}"
        return text + ("" if self.stated else ' (the default; "0 %" says exact)')


def _percent(share: float) -> str:
    return f"{100.0 * share:.3g} %"


def _sizes(plant: Plant) -> Mapping[str, float]:
    found: Mapping[str, float] = getattr(plant, "uncertain", {})
    return found


def _of_effects(plant: Plant) -> dict[str, float]:
    names = (effect.full_name(p.name) for effect in plant.effects for p in effect.fitted)
    return {name: abs(plant.parameters[name]) for name in names}


def _share(table: Table, key: str) -> float:
    share = table.quantity(key, "1")
    if not 0.0 <= share < 1.0:
        table.refuse(key, f"= {share:g}: expected a share from 0 to 100 %")
    return share
