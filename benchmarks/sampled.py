"""A grasp under the sampled controller: time and error, beside steps of the methods used before.

Twelve grasps (dynamometer, soft ball, free closure; four hands each) by the compiled steps alone,
without outputs. `tick by tick` is the method of rodas/whole_tick.py; `as continuous` takes each
tick by the methods of the continuous controller, with a Jacobian of its own. Both in one process,
in turn, processor time a grasp; the ratio is the median of those of what ran in turn, with its 95 %
interval. Errors are RMS over the trace, in shares of its peak, against steps of the former methods
at a tolerance of 1e-9: geometric means over the grasps. A count of the shipped encoder is a jump of
the duty, which any small difference sets off at another tick; so they are printed also for an
encoder with 2^30 counts, where what is left is the integrator's.
"""

import sys
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from unittest.mock import patch

import numpy as np
from tqdm import tqdm

from benchmarks.harness import Row, interval, main, must_show
from hannes.simulation.compiled_call import Plan
from hannes.simulation.compiler import assemble
from hannes.simulation.compiler.assemble import Compiled
from hannes.simulation.experiment.experiment import Experiment
from hannes.simulation.experiment.load import load_experiment
from hannes.simulation.hand.hand import Hand
from hannes.simulation.hand.model import EQUATIONS
from hannes.simulation.rodas import source

EXPERIMENTS = ("dynamometer", "soft-ball", "void-closure")
VARIED = ("motor.dry_friction", "mcp.moment_arm", "motor.torque_constant", "gear.pulley_radius")
HANDS, SPREAD = 4, 0.03
TRACES = ("current", "force", "leader_tension")
TOLERANCES = (1e-2, 1e-3, 1e-4, 1e-5)
EXACT = 1e-9
ENCODERS = {"shipped": None, "2^30 counts": 30.0}
WAYS = ("as continuous", "tick by tick")
ASKED = 1e-3  # tolerance at which a grasp is to take at most half its time
BOUND = 0.5
SMALLEST = 1e-6  # of a peak: a force that is nil has no error


@contextmanager
def as_continuous() -> Iterator[None]:
    """Models assembled within take ticks by the methods of the continuous controller."""
    text = source.source()
    former = text.replace("clock[1] == clock[2] - clock[0] and clock[1] <= clock[3]", "False")
    assert former != text
    with patch.object(source, "source", lambda: former):
        yield


def models() -> dict[str, Compiled]:
    """The hand without effects by both ways."""
    made = assemble._assembled.__wrapped__  # anew: it keeps one model for a set of effects
    with as_continuous():
        former = made(EQUATIONS, ())
    return dict(zip(WAYS, (former, made(EQUATIONS, ())), strict=True))


def grasps(bits: float | None) -> list[tuple[Hand, Experiment]]:
    """Hands, each a little different, and what they do."""
    rng, shipped, found = np.random.default_rng(3), Hand().parameters, []
    for name in EXPERIMENTS:
        experiment = replace(load_experiment(name)[0].experiment, controller="sampled")
        if bits is not None:
            experiment = replace(experiment, values={**experiment.values, "encoder.bits": bits})
        for _ in range(HANDS):
            factors = rng.uniform(1.0 - SPREAD, 1.0 + SPREAD, len(VARIED))
            values = {each: shipped[each] * k for each, k in zip(VARIED, factors, strict=True)}
            hand = Hand().with_values(values)
            found.append((hand.with_values(experiment.overrides()), experiment))
    return found


@dataclass(frozen=True)
class Case:
    """A grasp by one way at one tolerance, with and without the traces."""

    plan: Plan
    bare: Plan
    vectors: np.ndarray
    rest: np.ndarray

    @staticmethod
    def of(model: Compiled, hand: Hand, experiment: Experiment, rtol: float) -> "Case":
        """Plan it."""
        plan, bare = (Plan.of(model, experiment, rtol, each) for each in (TRACES, ()))
        vectors = hand.vector(experiment.shape, ())[np.newaxis]
        return Case(plan, bare, vectors, hand.rest(model)[np.newaxis])

    def traces(self) -> tuple[np.ndarray, np.ndarray]:
        """Traces (3, samples), and counts of evaluations, Jacobians, factorings, rejected steps."""
        ran = self.plan.run(self.vectors, self.rest.copy())
        if ran.counts[0, 4]:
            raise RuntimeError(f"a grasp at {self.plan.rtol:g} failed: {ran.counts[0]}")
        return ran.kept[0], ran.counts[0, :4]

    def seconds(self) -> float:
        """Processor time of the steps."""
        begun = time.process_time()
        self.bare.run(self.vectors, self.rest.copy())
        return time.process_time() - begun


def errors(found: list[np.ndarray], exact: list[np.ndarray]) -> dict[str, float]:
    """RMS and worst error of each trace [% of its peak], geometric means over the grasps."""
    rows = []
    for mine, reference in zip(found, exact, strict=True):
        peak = np.abs(reference).max(axis=1, keepdims=True)
        off = np.where(peak > SMALLEST, (mine - reference) / np.maximum(peak, SMALLEST), np.nan)
        rows.append([np.sqrt(np.mean(off**2, axis=1)), np.abs(off).max(axis=1)])
    middle = 100.0 * np.exp(np.nanmean(np.log(np.array(rows) + 1e-12), axis=0))
    names = [f"{name}_{kind}_%" for kind in ("rms", "worst") for name in TRACES]
    return dict(zip(names, middle.ravel().tolist(), strict=True))


def timed(cases: Mapping[str, list[Case]], turns: int) -> dict[str, np.ndarray]:
    """By way, milliseconds a grasp in each turn, forwards and backwards."""
    took: dict[str, list[float]] = {way: [] for way in cases}
    for turn in range(turns):
        for way in list(cases)[:: 1 if turn % 2 else -1]:
            took[way].append(1e3 * sum(each.seconds() for each in cases[way]) / len(cases[way]))
    return {way: np.array(each) for way, each in took.items()}


def measure(quick: bool) -> tuple[list[Row], list[Row]]:
    """Two rows for each tolerance and encoder; times with the shipped one."""
    print("sampled: compiling both ways", file=sys.stderr, flush=True)
    made, rows, bounds = models(), list[Row](), list[Row]()
    for encoder, bits in ENCODERS.items():
        given = grasps(bits)
        exact = [Case.of(made[WAYS[0]], *each, EXACT).traces()[0] for each in given]
        for rtol in tqdm(TOLERANCES, encoder, leave=False):
            cases = {way: [Case.of(made[way], *each, rtol) for each in given] for way in WAYS}
            took = timed(cases, 5 if quick else 25) if bits is None else {}
            pair = [_row(encoder, rtol, way, cases[way], exact, took) for way in WAYS]
            rows += pair
            if rtol == ASKED:
                bounds += _bounds(encoder, pair, took)
    return rows, bounds


def _row(
    encoder: str,
    rtol: float,
    way: str,
    cases: list[Case],
    exact: list[np.ndarray],
    took: Mapping[str, np.ndarray],
) -> Row:
    found = [each.traces() for each in cases]
    counts = np.mean([each[1] for each in found], axis=0)
    names = ("evaluations", "jacobians", "factorings", "rejected")
    return {
        "encoder": encoder,
        "rtol": f"{rtol:g}",
        "ticks": way,
        "ms": float(np.median(took[way])) if took else float("nan"),
        "over": float(np.median(took[way] / took[WAYS[0]])) if took else float("nan"),
        **{name: round(float(value)) for name, value in zip(names, counts, strict=True)},
        **errors([each[0] for each in found], exact),
    }


def _bounds(encoder: str, pair: list[Row], took: Mapping[str, np.ndarray]) -> list[Row]:
    """A sampled grasp takes at most half its time, at no larger errors."""
    found = []
    if took:
        ratios = took[WAYS[1]] / took[WAYS[0]]
        value = float(np.median(ratios))
        row = must_show(f"time over that before, at {ASKED:g}", value, BOUND, value <= BOUND)
        found.append(row | interval(ratios.tolist()))
    larger = max(
        float(pair[1][f"{name}_rms_%"]) / float(pair[0][f"{name}_rms_%"]) for name in TRACES
    )
    what = f"largest RMS error over that before, {encoder}"
    return [*found, must_show(what, larger, 1.0, larger <= 1.0)]


if __name__ == "__main__":
    main(__doc__, "sampled", measure)
