"""How uncertain the machine is: the table [diagnose] of a campaign, every part with a default."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

from hannes.core.io.toml_table import Table

if TYPE_CHECKING:  # the help of the command line shows these defaults, and answers at once
    from hannes.plants.protocol import Plant

KEYS = ("scatter", "run_scatter", "start_time", "scatter_apart", "work")
MOST_WORK = 50  # times the usual bound


@dataclass(frozen=True)
class Settings:
    """Standard deviations of what is uncertain, and how long a search may last.

    scatter:     share by which any nominal value of the machine may be off
    run_scatter: share by which friction varies from run to run; a plant's own run-to-run
                 variability (`run_to_run`) is for 1 %, and scales in proportion
    start_time:  s, of the moment at which a run starts
    scatter_apart: share by which each of several like parts (joints) is off for itself, besides
    work:        times the usual bound that a search may simulate
    """

    scatter: float = 0.03
    run_scatter: float = 0.01
    start_time: float = 0.0
    scatter_apart: float = 0.01
    work: int = 1


def read_settings(table: Table, plant: "Plant") -> Settings:
    """The settings of a campaign; BadInput for an unknown key, a wrong unit, an impossible size."""
    table = Table(table.content, table.where, KEYS, table.prefix)
    if table.content and not getattr(plant, "uncertain", {}):
        why = f"cannot be used: the plant {plant.name} does not say what is uncertain in it"
        table.refuse(next(iter(table.content)), why)
    return Settings(
        _share(table, "scatter", Settings.scatter),
        _share(table, "run_scatter", Settings.run_scatter),
        _time(table, plant),
        _share(table, "scatter_apart", Settings.scatter_apart, none=True),
        table.whole("work", 1, MOST_WORK, Settings.work),
    )


def _share(table: Table, key: str, default: float, none: bool = False) -> float:
    """A share above 0, or 0 too where that may be `none`."""
    share = table.quantity(key, "1", "2 %") if key in table else default
    if not (0.0 < share < 0.5 or (none and share == 0.0)):
        table.refuse(key, f"= {share:g}: expected a share between 0 and 50 %")
    return share


def _time(table: Table, plant: "Plant") -> float:
    usual = float(getattr(plant, "start_time", 0.0))
    spread = table.quantity("start_time", "s", "0.2 ms") if "start_time" in table else usual
    if spread < 0.0:
        table.refuse("start_time", f"= {spread:g} s: a standard deviation is not negative")
    return spread
