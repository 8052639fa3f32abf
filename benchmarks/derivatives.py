"""Derivatives of a simulation by its parameters, and of the fingers' rates by their states.

`simulations`: by runs of their own, and by runs that take the same steps. One dynamometer grasp of
the shipped hand; each of its uncertain values moved by one percent. What is printed: the error of
the current's change beside one at a tolerance of 1e-9, the median over all values and the largest,
in shares of the change itself, and the processor time of all runs over that of runs of their own at
1e-5. Values that move the current by less than a microampere are left out.

`fingers`: what the closed form of the fingers' Jacobian blocks saves over differences of one state
at a time. Dynamometer grasps at a tolerance of 1e-2, of the hand alone, with each effect that is
computed in the fingers, and with the whole catalogue; processor time, both ways in turn in one
process. `share_saved`: of a grasp's time with differences, with its 95 % interval; the evaluations
and Jacobians of a grasp by each way, and how far the currents are apart, as a share of the peak.
"""

import sys
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from unittest.mock import patch

import numpy as np
from tqdm import tqdm

from benchmarks.batch import SMALL, columns, grasp, with_effects
from benchmarks.harness import Row, aligned, interval, main
from hannes import effects
from hannes.core.effect import Effect
from hannes.plants.hand.plant import HandPlant
from hannes.simulation.batch.simulate_many import simulate_alike, simulate_many
from hannes.simulation.compiled_call import Plan
from hannes.simulation.compiler import assemble
from hannes.simulation.experiment.experiment import Experiment
from hannes.simulation.experiment.load import load_experiment
from hannes.simulation.hand.hand import Hand
from hannes.simulation.hand.jacobian import sparsity
from hannes.simulation.hand.model import EQUATIONS

PARTS = ("simulations", "fingers")
MOVED = 0.01  # of a value
LEAST = 1e-6  # A RMS
USUAL = 1e-5  # tolerance of runs of their own, to which times are compared
EXACT = 1e-9
GRASPS = 40  # in one turn
Changes = Callable[[float], np.ndarray]  # tolerance -> (values, samples) [A]


def moved_columns(hand: Hand, count: int) -> dict[str, np.ndarray]:
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


def simulations(quick: bool) -> list[Row]:
    """Rows of both ways at some tolerances."""
    hand, (found,) = Hand(), load_experiment("dynamometer")
    table = moved_columns(hand, 20 if quick else 1000)
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
            row = {"derivatives by": name, "tolerance": rtol, "seconds": spent}
            rows.append({**row, "error, median": median, "error, most": most})
    usual = float(rows[0]["seconds"])
    return [{**row, "seconds": row["seconds"] / usual} for row in rows]


def _changes(runs: np.ndarray) -> np.ndarray:
    return runs[1:] - runs[0]


def _size(changes: np.ndarray) -> np.ndarray:
    return np.sqrt(np.mean(changes**2, axis=1))


@contextmanager
def fingers_differenced() -> Iterator[None]:
    """Models assembled within have their fingers differenced, whatever effects they carry."""
    held = partial(sparsity.Arrowhead, plain_fingers=False)
    with patch.object(sparsity, "Arrowhead", held):
        yield


def both(present: tuple[Effect, ...]) -> dict[str, assemble.Compiled]:
    """The model with its fingers in closed form, and differenced."""
    made = assemble._assembled.__wrapped__  # anew: it keeps one model for a set of effects
    closed = made(EQUATIONS, present)
    with fingers_differenced():
        return {"closed": closed, "differenced": made(EQUATIONS, present)}


def in_fingers(effect: Effect) -> bool:
    """Whether a kernel of the effect is called in a stage of the fingers."""
    stages = [EQUATIONS.stage_of(term.writes[0]) for term in effect.terms]
    return any(sparsity.PARTS[stage] == "fingers" for stage in stages)


def finger_hands() -> dict[str, Hand]:
    """The hand alone, with each effect in the fingers, with all of the catalogue."""
    known = tuple(each for each in effects().values() if not EQUATIONS.accepts(each))
    single = {each.name: with_effects((each,), SMALL) for each in known if in_fingers(each)}
    whole = {f"all {len(known)} effects": with_effects(known, SMALL)}
    return {"no effect": Hand(), **single, **whole}


def grasps_timed(
    hand: Hand, models: Mapping[str, assemble.Compiled], repeats: int
) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray], dict[str, np.ndarray]]:
    """By model: ms a grasp of each turn, currents (grasps, samples), counts (grasps, 6)."""
    experiment = grasp()
    hand = hand.with_values(experiment.overrides())
    present = hand.present_effects()
    vectors = hand.vectors(experiment.shape, GRASPS, columns(GRASPS), present)
    plans = {
        name: Plan.of(model, experiment, 1e-2, ("current",)).make_ready()
        for name, model in models.items()
    }
    took: dict[str, list[float]] = {name: [] for name in plans}
    currents, counts = {}, {}
    for repeat in range(repeats + 1):
        for name in list(plans)[:: 1 if repeat % 2 else -1]:
            starts = hand.rests(models[name], vectors)
            begun = time.process_time()
            ran = plans[name].run(vectors, starts)
            spent = time.process_time() - begun
            took[name] += [1e3 * spent / GRASPS] * (repeat > 0)  # the first one warms
            currents[name], counts[name] = ran.kept[:, 0], ran.counts
    return {name: np.array(each) for name, each in took.items()}, currents, counts


def fingers(quick: bool) -> list[Row]:
    """A row for each hand."""
    rows: list[Row] = []
    hands = finger_hands()
    for name, hand in tqdm(list(hands.items())[: 1 if quick else None], "hands", leave=False):
        print(f"derivatives: {name}", file=sys.stderr, flush=True)
        models = both(hand.present_effects())
        took, currents, counts = grasps_timed(hand, models, 9 if quick else 41)
        closed, differenced = took["closed"], took["differenced"]
        saved = 1.0 - closed / differenced
        print(f"derivatives: {name}: {np.median(saved):.1%} saved", file=sys.stderr, flush=True)
        apart = np.abs(currents["closed"] - currents["differenced"]).max()
        each = {way: counts[way].mean(axis=0) for way in models}
        rows.append(
            {
                "fingers of the hand with": name,
                "closed_ms": float(np.median(closed)),
                "differenced_ms": float(np.median(differenced)),
                "share_saved": float(np.median(saved)),
                **interval(saved.tolist()),
                "evaluations": f"{each['closed'][0]:.0f}, {each['differenced'][0]:.0f}",
                "jacobians": f"{each['closed'][1]:.0f}, {each['differenced'][1]:.0f}",
                "apart": float(apart / np.abs(currents["closed"]).max()),
            }
        )
    return rows


def measured(quick: bool, only: tuple[str, ...] = PARTS) -> tuple[list[Row], list[Row]]:
    """Rows of the parts; nothing of it is a bound."""
    known = {"simulations": simulations, "fingers": fingers}
    return aligned([row for part in only for row in known[part](quick)]), []


if __name__ == "__main__":
    main(__doc__, "derivatives", measured, PARTS)
