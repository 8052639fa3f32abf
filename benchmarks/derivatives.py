"""Slopes of a simulation: by runs of their own, and by runs that take the same steps.

One dynamometer grasp of the shipped hand; each of its uncertain values moved by one percent. What
is printed: the error of the current's change beside one at a tolerance of 1e-9, the median over all
values and the largest, in shares of the change itself, and the processor time of all runs over
that of runs of their own at 1e-5. Values that move the current by less than a microampere are
left out.
"""

import time
from collections.abc import Callable

import numpy as np

from benchmarks.harness import Row, main
from hannes.plants.hand.plant import HandPlant
from hannes.simulation.batch.simulate_many import simulate_alike, simulate_many
from hannes.simulation.experiment.experiment import Experiment
from hannes.simulation.experiment.load import load_experiment
from hannes.simulation.hand.hand import Hand

MOVED = 0.01  # of a value
LEAST = 1e-6  # A RMS
USUAL = 1e-5  # tolerance of runs of their own, to which times are compared
EXACT = 1e-9
Changes = Callable[[float], np.ndarray]  # tolerance -> (values, samples) [A]


def columns(hand: Hand, count: int) -> dict[str, np.ndarray]:
    """Parameters in columns: first as they are, then one after the other moved."""
    names = [n for n in HandPlant(hand).uncertain if not n.startswith("object.")][:count]
    rows = np.repeat([[hand.parameters[name] for name in names]], len(names) + 1, axis=0)
    rows[1:] += MOVED * np.diag(rows[0])
    return dict(zip(names, rows.T, strict=True))


def ways(hand: Hand, experiment: Experiment, table: dict[str, np.ndarray]) -> dict[str, Changes]:
    """Name -> what the current of each row differs by from the first one's, by a tolerance."""

    def alone(rtol: float) -> np.ndarray:
        runs = simulate_many(hand, experiment, table, channels=["current"], rtol=rtol)
        return np.array([run["current"] for run in runs])

    def same_steps(rtol: float) -> np.ndarray:
        runs = simulate_alike(hand, experiment, table, channels=["current"], rtol=rtol)
        return np.array([run["current"] for run in runs])

    return {"runs of their own": alone, "the same steps": same_steps}


def measured(quick: bool) -> tuple[list[Row], list[Row]]:
    """Rows of both ways at some tolerances; nothing of it is a bound."""
    hand, (found,) = Hand(), load_experiment("dynamometer")
    table = columns(hand, 20 if quick else 1000)
    tried = ways(hand, found.experiment, table)
    exact = _changes(tried["runs of their own"](EXACT))
    kept = _size(exact) > LEAST
    exact = exact[kept]
    rows: list[Row] = []
    for name, way in tried.items():
        for rtol in (USUAL, 1e-4):
            way(rtol)  # compiled
            begun = time.process_time()
            made = way(rtol)
            spent = time.process_time() - begun
            off = _size(_changes(made)[kept] - exact) / _size(exact)
            median, most = float(np.median(off)), float(off.max())
            row = {"slopes by": name, "tolerance": rtol, "seconds": spent}
            rows.append({**row, "error, median": median, "error, most": most})
    usual = float(rows[0]["seconds"])
    return [{**row, "seconds": row["seconds"] / usual} for row in rows], []


def _changes(runs: np.ndarray) -> np.ndarray:
    return runs[1:] - runs[0]


def _size(changes: np.ndarray) -> np.ndarray:
    return np.sqrt(np.mean(changes**2, axis=1))


if __name__ == "__main__":
    main(__doc__, "derivatives", measured)
