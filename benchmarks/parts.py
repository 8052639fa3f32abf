"""Parts of a step: nanoseconds of the rates, of the Jacobian, of its factors and of a solution.

Along the states of a dynamometer grasp, of the hand alone, with its whole catalogue at small
amplitudes, and with all of it in the model but at off; processor time, medians over turns and the
distance of their quartiles. An accepted step takes one Jacobian, and by Rodas4P2 six rates and
solutions, by Rodas3 three and four; each attempt takes new factors.
"""

import time
from typing import Any

import numpy as np
from tqdm import tqdm

from benchmarks.batch import SMALL, grasp, with_effects
from benchmarks.harness import Row, aligned, main
from hannes import Hand, effects, simulate
from hannes.core.kernels.jit import kernel
from hannes.simulation.compiler.assemble import Compiled
from hannes.simulation.hand.model import EQUATIONS
from hannes.simulation.trajectory import Trajectory

PARTS = ("rates", "Jacobian", "factors", "solution")
SHIFT = 1e3  # 1/s: of a step of 4 ms
ROUNDS = 20  # through all states in one turn


def turns(compiled: Compiled) -> Any:
    """Compile a loop that takes each state through the first parts of a step, `depth` of them."""
    fast = compiled.fast
    kind, prepare, slope, linearise = fast.WORKSPACE, fast.prepare, fast.slope, fast.linearise
    decompose, resolve = fast.decompose, fast.resolve

    @kernel
    def within(room, depth, times, states, p, knots, memory, rounds):
        data = room[0]
        prepare(data, p, knots, memory)
        rates, drift = np.zeros(states.shape[1]), np.zeros(states.shape[1])
        total = 0.0
        for _ in range(rounds):
            for k in range(times.size):
                slope(times[k], states[k], rates, data)
                if depth > 1:
                    linearise(times[k], states[k], rates, drift, data)
                if depth > 2:
                    decompose(SHIFT, data)
                if depth > 3:
                    resolve(rates, data)
                total += rates[0] + drift[0]
        return total

    @kernel
    def run(depth, times, states, p, knots, memory, rounds):
        room = np.zeros(1, kind)
        return within(room, depth, times, states, p, knots, memory, rounds)

    return run


def spent(ran: Trajectory, repeats: int) -> np.ndarray:
    """Nanoseconds of each part, shape (parts, turns): what a turn took with it less without."""
    run = turns(ran.compiled)
    given = (
        ran.time[::10],
        ran.states[::10].copy(),
        ran.parameters,
        ran.knots,
        ran.memories[0].copy(),
    )
    sums: list[list[float]] = [[] for _ in PARTS]
    for _ in tqdm(range(repeats + 1), "turns", leave=False):
        for depth in range(len(PARTS)):
            clock = time.process_time()
            run(depth + 1, *given, ROUNDS)
            sums[depth].append(time.process_time() - clock)
    each = 1e9 * np.array(sums)[:, 1:] / (ROUNDS * given[0].size)
    return np.diff(each, axis=0, prepend=0.0)


def measure(quick: bool) -> tuple[list[Row], list[Row]]:
    """A row for each hand; no bound is asked for."""
    known = tuple(each for each in effects().values() if not EQUATIONS.accepts(each))
    hands = {"0 effects": Hand()}
    hands |= {f"{len(known)} effects": with_effects(known, SMALL)}
    hands |= {f"{len(known)} effects, at off": with_effects(known, 0.0)}
    rows = []
    for name, hand in hands.items():
        ran = simulate(hand, grasp(), rtol=1e-3, effects=hand.effects).require()
        row: Row = {"hand": name, "states": ran.states.shape[1]}
        for part, took in zip(PARTS, spent(ran, 5 if quick else 50), strict=True):
            low, middle, high = np.percentile(took, (25, 50, 75))
            row |= {f"{part}_ns": float(middle), f"{part}_spread": float(high - low)}
        rows.append(row)
    return aligned(rows), []


if __name__ == "__main__":
    main(__doc__, "parts", measure)
