"""Whether a residual goes with the order of the runs: against every other order of them.

A machine that creeps or warms leaves a residual that changes steadily. Where nothing depends on the
order, every order of a command's runs is as likely as the one in which they were made.
"""

from collections.abc import Sequence
from itertools import permutations
from typing import Any

import numpy as np

from hannes.identification.pattern.blocks import Command
from hannes.identification.pattern.jackknife import LEVEL, STATEMENTS

FEWEST = 4  # runs of a command that show an order
# Runs of a command whose orders are all tried; of more, these many evenly. Of fewer runs of a
# single command any order, with its reverse, is likelier by chance than what is said may be.
MOST = 7
DRAWN = 20_000  # orders of all commands together
LEAST = 0.3  # of what runs differ by, that goes with their order


def drift(known: Sequence[Command]) -> dict[str, Any] | None:
    """`changes steadily from run to run`, where that is beyond chance.

    value: share of what runs differ by that goes with their order
    """
    shares = [_shares(each) for each in known if each.runs >= FEWEST]
    if not shares:
        return None
    whole, made = sum(size for _, size in shares), sum(found[0] for found, _ in shares)
    rng = np.random.default_rng(0)
    others = np.sum([rng.choice(found, DRAWN) for found, _ in shares], axis=0)
    value = float(made / whole) if whole else 0.0
    by_chance = float(np.mean(others >= made * (1.0 - 1e-9)))
    if value < LEAST or by_chance > LEVEL / STATEMENTS:
        return None
    return {"what": "changes steadily from run to run", "value": value, "low": LEAST}


def _shares(command: Command) -> tuple[np.ndarray, float]:
    """What of the squared differences of runs a straight line takes, in each order; and of all.

    The first order is the one in which they were made.
    """
    kept = np.unique(np.linspace(0, command.runs - 1, min(MOST, command.runs)).astype(int))
    rows = command.residual[kept] / command.spread
    rows = (rows - rows.mean(axis=0)).reshape(kept.size, -1)
    products, at = rows @ rows.T, command.numbers[kept] - command.numbers[kept].mean()
    orders = at[np.array(list(permutations(range(kept.size))))]
    taken = np.sum(orders @ products * orders, axis=1) / (at @ at)
    return taken, float(np.trace(products))
