"""The energy ledger over every shipped experiment: is all that goes into the motor found again?"""

import sys

from hannes import library
from hannes.ledger import account
from hannes.report.checks import RTOL, Row, row
from hannes.spec import load
from hannes.variants import Variant

WITHIN = 0.1  # % of the electrical energy


def energy_row(progress: bool | None = None) -> Row:
    """The largest share of any run's electrical energy that its ledger does not account for."""
    from tqdm import tqdm

    found = [load(name) for name in library.names()]
    runs = [each for variants in found if isinstance(variants, list) for each in variants]
    hidden = None if progress is None else not progress
    bar = tqdm(runs, "energy", delay=1.0, disable=hidden, file=sys.stderr, unit="run", leave=False)
    name = f"energy unaccounted for, worst of {len(runs)} runs of the shipped experiments"
    return row(name, 100.0 * max(map(_unaccounted, bar)), WITHIN, "%")


def _unaccounted(variant: Variant) -> float:
    return abs(account(variant.hand, variant.experiment, rtol=RTOL)["residual"])
