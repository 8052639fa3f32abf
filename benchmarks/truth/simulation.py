"""`simulate`: a recording of the second hand, with what is hidden in it."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from benchmarks.truth._jit import compiled
from benchmarks.truth.controller import encoder, rounded, sampled
from benchmarks.truth.integrator import GAMMA, SCALE, linearise, step
from benchmarks.truth.motion import SIZE, rates, rest_state
from benchmarks.truth.record import pack

# Effect as the library's catalogue names it -> (its parameter there, field of the kernels' record)
EFFECTS = {
    "leader_slack": ("length", "slack"),
    "direction_friction": ("dry", "asymmetry"),
    "gear_load": ("coefficient", "load_loss"),
}
# Standard deviations of the sensors' white noise where a generator is given.
NOISE = {"current": 10e-3, "supply": 5e-3, "force": 0.2}
QUIET = {"current": 0.0, "supply": 0.0, "force": 0.0}


@compiled
def _at(knots, t):
    """Piecewise linear reference (rows: s, motor-side rad), constant outside."""
    if t <= knots[0, 0]:
        return knots[0, 1]
    for k in range(1, knots.shape[0]):
        if t <= knots[k, 0]:
            part = (t - knots[k - 1, 0]) / (knots[k, 0] - knots[k - 1, 0])
            return knots[k - 1, 1] + part * (knots[k, 1] - knots[k - 1, 1])
    return knots[-1, 1]


@compiled
def _advance(h, y, slope, knots, t, duration, full, duty, is_sampled, scale, work, new, worn):
    """Carries y over `duration` in steps of `full`, smaller where Newton fails.

    Returns (reached the end, Jacobian worn out).
    """
    done, size = 0.0, full
    while done < duration * (1.0 - 1e-9):
        here = t + done
        if worn:
            reference = _at(knots, here)
            linearise(h, y, reference, duty, is_sampled, GAMMA * size, scale, work)
        stages = (_at(knots, here + GAMMA * size), _at(knots, here + size))
        good, worn = step(h, y, slope, stages, duty, is_sampled, size, scale, work, new)
        if good:
            done += size
        else:
            size *= 0.5
            if size < 1e-4 * full:
                return False, True
    return True, worn or size != full


@compiled
def _run(h, y, knots, shift, substeps, is_sampled, noise, scale, out, states):
    """Fills, at each tick, out (reference, position, current, duty, force) and states.

    shift: s, how much later the hand runs than the clock of the record. Returns the ticks reached.
    """
    period, ratio = h.controller_period, h.gear_ratio
    n = y.shape[0]
    work = (np.zeros((n, n)), np.zeros(n, np.int64), np.zeros(n), np.zeros(n), np.zeros(n))
    slope, new, dy, memory = np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(4)
    duty, worn = 0.0, True
    for k in range(out.shape[0]):
        t = k * period - shift
        reference = _at(knots, t)
        shaft, current = y[24] / ratio, y[26] + noise[k]
        if is_sampled:
            shaft = encoder(h, shaft)
            current = rounded(current, h.controller_current_step)
            duty = sampled(h, reference, shaft * ratio, current, memory)
        used, force = rates(h, y, reference, duty, is_sampled, dy)
        out[k, 0], out[k, 1], out[k, 2] = _at(knots, k * period) / ratio, shaft, current
        out[k, 3], out[k, 4], states[k] = used, force, y
        size = period / substeps
        good, worn = _advance(
            h, y, slope, knots, t, period, size, duty, is_sampled, scale, work, new, worn
        )
        if not good:
            return k
    return out.shape[0]


def _hidden(effects: Mapping[str, float]) -> dict[str, float]:
    for name in effects:
        if name not in EFFECTS:
            raise ValueError(f"no effect is called {name}; expected one of {', '.join(EFFECTS)}")
    return {EFFECTS[name][1]: size for name, size in effects.items()}


def trace(
    parameters: Mapping[str, Any],
    reference: Sequence[Sequence[float]],
    object: Mapping[str, Any] | None = None,
    duration: float = 1.15,
    effects: Mapping[str, float] | None = None,
    controller: str = "sampled",
    rng: np.random.Generator | None = None,
    noise: Mapping[str, float] | None = None,
    step_size: float = 50e-6,
    shift: float = 0.0,
) -> tuple[dict[str, np.ndarray], np.ndarray]:
    """The channels of `simulate`, and the states (samples, 30) in the order of `motion`."""
    if controller not in ("sampled", "continuous"):
        raise ValueError(f"expected controller sampled or continuous, came {controller}")
    h = pack(parameters, object, **_hidden(effects or {}))
    ticks = round(duration / h.controller_period) + 1
    knots = np.array(reference, float) * (1.0, h.gear_ratio)
    sigma = dict(QUIET if rng is None else NOISE, **(noise or {}))
    draws = (rng or np.random.default_rng(0)).standard_normal((3, ticks))
    out, states = np.zeros((ticks, 5)), np.zeros((ticks, SIZE))
    substeps = max(1, round(h.controller_period / step_size))
    sampling = controller == "sampled"
    current_noise = sigma["current"] * draws[0]
    reached = _run(
        h, rest_state(h), knots, shift, substeps, sampling, current_noise, SCALE, out, states
    )
    if reached < ticks:
        raise RuntimeError(f"the step at {reached * h.controller_period:.3f} s did not converge")
    channels = {
        "time_s": np.arange(ticks) * h.controller_period,
        "reference_rad": out[:, 0],
        "position_rad": out[:, 1],
        "current_A": out[:, 2],
        "duty_1": out[:, 3],
        "supply_V": h.supply_voltage + sigma["supply"] * draws[1],
        "force_N": out[:, 4] + sigma["force"] * draws[2],
    }
    return channels, states


def simulate(
    parameters: Mapping[str, Any], reference: Sequence[Sequence[float]], **options: Any
) -> dict[str, np.ndarray]:
    """Channels at 1 kHz: time_s, reference_rad, position_rad, current_A, duty_1, supply_V, force_N.

    parameters: SI values by name (see `parameters.NOMINAL`); the missing ones are nominal.
    reference: points (s, rad at the output shaft), linear between. Options, all by name, as in
    `trace`:
    object: shape ("cylinder" along z, or "sphere"), radius, position (hand frame), stiffness,
    damping, friction. duration: s. effects: size by name of EFFECTS.
    controller: "sampled" (quantised encoder, zero-order hold) or "continuous".
    rng: switches sensor noise on (`noise`: standard deviations, default NOISE).
    step_size: s, rounded to a whole number of steps in 1 ms. shift: s, how much later the hand runs
    than the clock of the record.
    Raises ValueError on bad input, RuntimeError where Newton's method fails at the smallest step.
    """
    return trace(parameters, reference, **options)[0]
