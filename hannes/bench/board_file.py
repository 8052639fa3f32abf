"""A virtual board from a TOML file: which hand and object, what it hides, what goes wrong.

experiment = "dynamometer"        # its hand, effects, object and noise; a name or a .toml file
[board]                           # all of it may be left out
watchdog = "200 ms"
current_limit = "6 A"
[misbehaviour]
lost = "0.1 %"                    # of packets; also repeated, damaged
late = "5 ms"                     # longest delay
cut = "3 s"                       # the cable is out from then on, for cut_for
drift = "0.004 %"                 # of the board's clock
"""

from dataclasses import dataclass, replace
from pathlib import Path

from hannes.bench.board_logic import Limits, Settings
from hannes.bench.misbehaviour import Misbehaviour
from hannes.core.errors import BadInput
from hannes.core.io.toml_table import Table, read_text
from hannes.simulation.experiment.load import load_experiment
from hannes.simulation.experiment.variants import Variant

KEYS = ("experiment", "variant", "seed", "board", "misbehaviour")
BOARD = {"watchdog": "s", "current_limit": "A", "temperature_limit": "K", "travel_limit": "rad"}
SHARES = ("lost", "repeated", "damaged", "drift")
TIMES = ("late", "stall", "stall_for", "cut", "cut_for", "reset")
LONGEST = 1e6  # s, of any time
FASTEST_DRIFT = 0.5  # of the board's clock


@dataclass(frozen=True)
class BoardFile:
    """What a virtual board is made of."""

    variant: Variant
    settings: Settings
    how: Misbehaviour


def read_board(name: str | Path) -> BoardFile:
    """Read a board's TOML, or take an experiment (a shipped name or a .toml file) as it is.

    Raises BadInput with file and key for whatever cannot be used.
    """
    path = Path(name)
    if not str(name).endswith(".toml") or "reference" in Table.parse(
        read_text(path), str(path), ()
    ):
        return BoardFile(_one(load_experiment(name), str(name), 1), Settings(), Misbehaviour())
    root = Table.parse(read_text(path), str(path), KEYS)
    root.require("experiment", '"dynamometer"')
    found = root.text("experiment", "")
    target = path.parent / found if found.endswith(".toml") else found
    number = root.whole("variant", 1, 10_000, 1)
    variant = _one(load_experiment(target), found, number)
    seed = root.whole("seed", 0, 2**31, 1)
    return BoardFile(variant, _settings(root), _misbehaviour(root, seed))


def _one(variants: list[Variant], name: str, number: int) -> Variant:
    if number > len(variants):
        raise BadInput(f"{name}: has {len(variants)} variants, none with number {number}")
    return variants[number - 1]


def _settings(root: Table) -> Settings:
    table = root.table("board", tuple(BOARD))
    settings = Settings()
    values = {key: table.quantity(key, BOARD[key]) for key in BOARD if key in table}
    for key, value in values.items():
        if not value > 0.0:
            table.refuse(key, f"= {value:g} {BOARD[key]}: expected more than zero")
    if not values.get("watchdog", 0.0) <= LONGEST:
        table.refuse("watchdog", f"= {values['watchdog']:g} s: expected at most {LONGEST:g} s")
    limits = settings.limits
    limits = Limits(
        values.get("current_limit", limits.current),
        values.get("temperature_limit", limits.temperature + 273.15) - 273.15,
        limits.travel_low,
        values.get("travel_limit", limits.travel_high),
    )
    watchdog = round(1e6 * values.get("watchdog", 1e-6 * settings.watchdog))
    return replace(settings, watchdog=watchdog, limits=limits)


def _misbehaviour(root: Table, seed: int) -> Misbehaviour:
    table = root.table("misbehaviour", (*SHARES, *TIMES, "garbled"))
    values = {key: table.quantity(key, "1") for key in SHARES if key in table}
    for key in ("lost", "repeated", "damaged"):
        if not 0.0 <= values.get(key, 0.0) <= 1.0:
            table.refuse(key, f"= {values[key]:g}: expected a share from 0 to 1")
    values |= {key: table.quantity(key, "s") for key in TIMES if key in table}
    for key in TIMES:
        if not 0.0 <= values.get(key, 0.0) <= LONGEST:
            table.refuse(key, f"= {values[key]:g} s: expected 0 to {LONGEST:g} s")
    if not abs(values.get("drift", 0.0)) <= FASTEST_DRIFT:
        table.refuse(
            "drift", f"= {values['drift']:g}: expected at most {FASTEST_DRIFT:g} to a side"
        )
    return Misbehaviour(**values, garbled=table.flag("garbled"), seed=seed)
