"""A tick of a sampled controller in one step: two evaluations, and a Jacobian kept from before.

Firmware holds its duty from tick to tick. At each tick the voltage jumps, and the winding's current
settles within a few L / R, a small part of the tick. What a method leaves of that transient in one
long step is its largest error there: R(h lambda) of it, which for Rodas4P2 is a sixth, for Rodas3 a
twelfth where h lambda is -22 as for the shipped motor. Here it is a twenty-fifth. With
S = (1 - gamma h J)^-1, f = f(t, y), k_1 = gamma h S f and k_(i+1) = S k_i:

    bend   = f(t + c h, y + k_1 + (c / gamma - 1) k_2), less what f and J make of that place
    y(t+h) = y + k_1 + k_2 + (1 / gamma - 2) k_3 + 3/4 h S bend,                      c = 2/3
    error  = 3/4 h S bend + zeta (k_3 - k_2)

Where f is linear its stability function is R(z) = r s^2 + (1 - r) s^3, s = 1 / (1 - gamma z),
r = 3 - 1 / gamma: of order 2 for this gamma, L-stable, and falling as z^-2. The method has order 2
whatever J is (a W-method: Steihaug & Wolfbrandt 1979, Mathematics of Computation 33, 521-534). So
J and its factors may be those of a tick before.
"""

import math

from hannes.core.kernels.jit import fused
from hannes.simulation.rodas.linear_algebra import copy_to, scaled_size
from hannes.simulation.rodas.step import advance

TICK_GAMMA = 0.5 - math.sqrt(1.0 / 12.0)
TICK_PLACE = 2.0 / 3.0  # c
TICK_AHEAD = TICK_PLACE / TICK_GAMMA - 1.0
TICK_WEIGHT = 0.75 / TICK_GAMMA
TICK_LAST = 1.0 / TICK_GAMMA - 2.0
TICK_CURVED = 0.5 / TICK_GAMMA**2  # of the dense output
TICK_ZETA = 0.3  # smaller, and at tolerances below 1e-3 errors grow more than time falls
# An old J bends the way as curvature does. At an error of this in units of 1 it is made anew at the
# next tick, at three times it at once: a tension that begins under an old J would overshoot.
TICK_STALE, TICK_STALE_MOST = 1e-4, 0.3
TICK_KEPT = 5  # place in the clock of the step whose factors are kept, 0 for none


def advance_tick(problem, data, y, rtol, atol, clock, counts, bounds, ends, pieces, work):
    """`advance` to the one of `bounds`, the next tick, before which firmware's duty is held."""
    if clock[1] == clock[2] - clock[0] and clock[1] <= clock[3]:
        ends[0] = clock[0]
        copy_to(pieces[0, 0], y)
        if whole_tick(problem, data, y, rtol, atol, clock, counts, pieces[0], work):
            ends[1] = clock[0]
            copy_to(pieces[1, 0], y)
            return 1
    return advance(problem, data, y, rtol, atol, clock, counts, bounds, ends, pieces, work)


def whole_tick(problem, data, y, rtol, atol, clock, counts, piece, work):
    """Take the step to the bound ahead, where its error allows that; whether it was taken."""
    first, second, third, bend = work[0], work[1], work[2], work[3]
    rates, drift, moved, error, value = work[6], work[7], work[8], work[9], work[10]
    t, h = clock[0], clock[1]
    per = 1.0 / (TICK_GAMMA * h)
    stale, size = min(TICK_STALE_MOST, TICK_STALE / rtol), 0.0
    old = abs(clock[TICK_KEPT] - h) <= 1e-6 * h
    problem.slope(t, y, rates, data)
    counts[0] += 1
    while True:
        if not old:
            problem.linearise(t, y, rates, drift, data)
            problem.decompose(per, data)
            counts[1] += 1
            counts[2] += 1
        settle(problem, data, y, per, first, second, third, rates, moved)
        problem.slope(t + TICK_PLACE * h, moved, value, data)
        counts[0] += 1
        for i in range(y.size):
            bend[i] = value[i] - per * fused(TICK_AHEAD, second[i] - first[i], first[i])
        problem.resolve(bend, data)
        for i in range(y.size):
            added = TICK_WEIGHT * bend[i]
            moved[i] = y[i] + (fused(TICK_LAST, third[i], first[i] + second[i]) + added)
            error[i] = fused(TICK_ZETA, third[i] - second[i], added)
        size = scaled_size(error, y, moved, rtol, atol, value)
        if size < (3.0 * stale if old else 1.0):
            break
        if not old:
            clock[TICK_KEPT] = 0.0
            counts[3] += 1
            return False
        old = False
        problem.slope(t, y, rates, data)  # `linearise` follows it
        counts[0] += 1
    for i in range(y.size):
        piece[1, i], piece[2, i] = TICK_CURVED * (second[i] - third[i]), 0.0
    copy_to(y, moved)
    clock[0], clock[TICK_KEPT] = clock[2], 0.0 if old and size > stale else h
    return True


def settle(problem, data, y, per, first, second, third, rates, moved):
    """Compute k_1 to k_3, and where to look ahead."""
    copy_to(first, rates)
    problem.resolve(first, data)
    for i in range(y.size):
        second[i] = per * first[i]
    problem.resolve(second, data)
    for i in range(y.size):
        third[i] = per * second[i]
    problem.resolve(third, data)
    for i in range(y.size):
        moved[i] = fused(TICK_AHEAD, second[i], y[i] + first[i])
