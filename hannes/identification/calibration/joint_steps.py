"""Gauss-Newton steps of all at once: what is asked for, and what is uncertain beside it.

A pulley and the arms that its wire pulls are known by their ratio. Along such a valley one moves
only with the other: a search over the one, the other held, would end on its slope.
"""

import numpy as np

from hannes.core.errors import ComputationFailed
from hannes.identification.calibration.linearisation import Maker, State
from hannes.identification.calibration.tuning import CALIBRATION


def joint_steps(maker: Maker, state: State) -> State:
    """The state after steps of all parameters, each with derivatives at its own point."""
    for _ in range(CALIBRATION.joint_steps):
        step, uncertain, deviation = _step(state)
        share = _share(step, uncertain - state.uncertain_values)
        x = np.clip(state.x + share * step, state.scales.low, state.scales.high)
        moved = state.uncertain_values + share * (uncertain - state.uncertain_values)
        try:
            state = maker.anew(state, x, moved)
        except ComputationFailed:
            return state
        if np.all(np.abs(step) < CALIBRATION.short_step * deviation):
            return state
    return state


def _step(state: State) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Step of x, values of uncertain parameters after it, and deviations of x; (p,), (q,), (p,)."""
    count, simulated = state.x.size, len(state.plan.uncertain)
    pairs = zip(state.whitenings, state.columns, state.uncertain_columns, strict=True)
    rows = np.hstack([white(np.vstack([own, rest])) for white, own, rest in pairs])
    left = np.concatenate(
        [white(each) for white, each in zip(state.whitenings, state.residuals, strict=True)]
    )
    at = np.zeros(len(rows))
    at[:count], at[count : count + simulated] = state.x, state.uncertain_values
    prior = np.concatenate([state.scales.prior**2, np.ones(len(rows) - count)])
    information = rows @ rows.T + np.diag(prior)
    found = at - np.linalg.solve(information, rows @ left + prior * at)
    uncertain = found[count : count + simulated].copy()
    uncertain[len(state.plan.doubt) :] = 0.0  # no simulation has single parts
    deviation = np.sqrt(np.diag(np.linalg.inv(information))[:count])
    return found[:count] - state.x, uncertain, deviation


def _share(step: np.ndarray, uncertain: np.ndarray) -> float:
    """Of a step, as far as derivatives may be believed."""
    far = np.abs(step).max(initial=0.0) / CALIBRATION.longest_step
    return float(1.0 / max(1.0, far, np.abs(uncertain).max(initial=0.0)))
