"""The energy balance of every shipped experiment: is all electrical energy accounted for?"""

import sys

from hannes.report.paper.checks import RTOL, Row, row
from hannes.simulation.energy_balance import account
from hannes.simulation.experiment import shipped
from hannes.simulation.experiment.load import load
from hannes.simulation.experiment.variants import Variant

WITHIN = 0.1  # % of the electrical energy


def energy_row(progress: bool | None = None) -> Row:
    """The largest share of electrical energy that a run's balance does not account for."""
    from hannes.core.io.progress import progress_bar

    found = [load(name) for name in shipped.names()]
    runs = [each for variants in found if isinstance(variants, list) for each in variants]
    hidden = None if progress is None else not progress
    bar = progress_bar(
        runs, "energy", delay=1.0, disable=hidden, file=sys.stderr, unit="run", leave=False
    )
    name = f"energy unaccounted for, worst of {len(runs)} runs of the shipped experiments"
    return row(name, 100.0 * max(map(_unaccounted, bar)), WITHIN, "%")


def _unaccounted(variant: Variant) -> float:
    return abs(account(variant.hand, variant.experiment, rtol=RTOL)["residual"])
