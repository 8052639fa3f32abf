"""`simulate`: what a hand does and what its controller and sensors read, at every tick."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from benchmarks.truth._jit import compiled
from benchmarks.truth.controller import encoder, rounded, sampled
from benchmarks.truth.effects import (
    clock_error,
    command_delay,
    encoder_eccentricity,
    measurement_delay,
)
from benchmarks.truth.integrator import advance, reference_at, workspace
from benchmarks.truth.motion import rates, rest_state
from benchmarks.truth.record import pack
from benchmarks.truth.state import (
    CREPT,
    FACE,
    FORCE_READING,
    SHAFT,
    SIZE,
    UNKNOWNS,
)

TOLERANCE = 3e-4  # of a step, in units of state.SCALE
LONGEST = 1e-3  # s
COLUMNS = ("reference_rad", "position_rad", "current_A", "duty_1", "supply_V", "force_N")
COLUMNS += ("sensor_N",)
# What acts in the firmware's periods alone.
SAMPLED = ("measurement_delay.time", "thermal_derating.fall", "clock_error.share")


@compiled
def measured(h, seen, k, back):
    """Readings of shaft angle (rad) and current (A) at tick k."""
    return (seen[k - back, 0], seen[k - back, 1]) if k >= back else (0.0, 0.0)


@compiled
def tick(h, y, dy, t, knots, reported, duty, memory, is_sampled):
    """One tick: the firmware's new duty, and all rates with it; also the bus voltage."""
    reference = reference_at(knots, command_delay.heard(h, t))
    if is_sampled:
        duty = sampled(h, reference, reported[0] * h.gear_ratio, reported[1], memory)
    duty, bus, _ = rates(h, y, 0.0, reference, duty, is_sampled, y, dy)
    return duty, bus


@compiled
def run(h, y, knots, shift, is_sampled, noise, control, unknowns, out, states):
    """Fills, at each tick, out (COLUMNS; forces without noise) and states; the ticks reached.

    shift: s, how much later the hand runs than the clock of the record; noise: of the current (A).
    """
    work = workspace(unknowns.shape[0])
    stages = (np.zeros(SIZE), np.zeros(SIZE), np.zeros(SIZE), np.zeros(SIZE), np.zeros(SIZE))
    dy, memory = np.zeros(SIZE), np.zeros(5)
    seen, pace = np.zeros((out.shape[0], 2)), np.array([control[1], 0.0, 1.0])
    period, slow, duty = h.controller_period, clock_error.lasting(h), 0.0
    back, part = measurement_delay.looked_up(h, period)
    for k in range(out.shape[0]):
        t = k * period - shift
        if part == 0.0:
            seen[k, 0] = encoder_eccentricity.seen(h, y[SHAFT])
            seen[k, 1] = rates(h, y, 0.0, reference_at(knots, t), duty, is_sampled, y, dy)[2]
        shaft, current = measured(h, seen, k, back)
        current += noise[k]
        if is_sampled:
            shaft, current = encoder(h, shaft), rounded(current, h.controller_current_step)
        duty, bus = tick(h, y, dy, t, knots, (shaft, current), duty, memory, is_sampled)
        asked = reference_at(knots, k * period) / h.gear_ratio
        out[k, 0], out[k, 1], out[k, 2] = asked, shaft, current
        out[k, 3], out[k, 4], out[k, 5], out[k, 6] = duty, bus, y[FORCE_READING], y[FACE]
        states[k] = y
        drive, late = (duty, is_sampled), command_delay.heard(h, t)
        if part > 0.0:
            if not advance(
                h, y, dy, late, part * slow, knots, drive, control, unknowns, stages, work, pace
            ):
                return k
            seen[k, 0] = encoder_eccentricity.seen(h, y[SHAFT])
            seen[k, 1] = rates(h, y, 0.0, 0.0, duty, is_sampled, y, dy)[2]
        rest = (period - part) * slow
        if not advance(
            h, y, dy, late + part, rest, knots, drive, control, unknowns, stages, work, pace
        ):
            return k
    return out.shape[0]


def trace(
    parameters: Mapping[str, Any],
    reference: Sequence[Sequence[float]],
    object: Mapping[str, Any] | None = None,
    duration: float = 1.15,
    effects: Mapping[str, float] | None = None,
    controller: str = "sampled",
    current_noise: np.ndarray | None = None,
    shift: float = 0.0,
    crept: float = 0.0,
    tolerance: float = TOLERANCE,
    longest: float = LONGEST,
) -> tuple[dict[str, np.ndarray], np.ndarray]:
    """The channels of `simulate`, and the states (samples, state.SIZE)."""
    h = pack(parameters, object, effects)
    _check(h, controller)
    ticks = round(duration / h.controller_period) + 1
    knots = np.array(reference, float) * (1.0, h.gear_ratio)
    out, states = np.zeros((ticks, len(COLUMNS))), np.zeros((ticks, SIZE))
    noise = np.zeros(ticks) if current_noise is None else current_noise
    start = rest_state(h)
    start[CREPT] = crept
    unknowns = UNKNOWNS[:-1] if h.gear_backlash_gap == 0.0 else UNKNOWNS
    reached = run(
        h,
        start,
        knots,
        shift,
        controller == "sampled",
        noise,
        (tolerance, longest),
        unknowns,
        out,
        states,
    )
    if reached < ticks:
        raise RuntimeError(f"no step converges at {reached * h.controller_period:.3f} s")
    time = np.arange(ticks) * h.controller_period
    return {"time_s": time, **dict(zip(COLUMNS, out.T.copy(), strict=True))}, states


def _check(h: np.record, controller: str) -> None:
    if controller not in ("sampled", "continuous"):
        raise ValueError(f"expected controller sampled or continuous, came {controller}")
    for name in SAMPLED:
        if controller == "continuous" and h[name.replace(".", "_")] != 0.0:
            raise ValueError(f"{name} needs the sampled controller")


def simulate(
    parameters: Mapping[str, Any], reference: Sequence[Sequence[float]], **options: Any
) -> dict[str, np.ndarray]:
    """Channels at 1 kHz: time_s, reference_rad, position_rad, current_A, duty_1, supply_V,
    force_N (sum of normal forces), sensor_N (push on the object's face towards the palm).

    parameters: SI values by name (see `parameters.NOMINAL`); the missing ones are nominal.
    reference: points (s, rad at the output shaft), linear between. Options, all by name, as in
    `trace`:
    object: shape ("cylinder" or "prism" along z, or "sphere") and what differs from the hand's
    `object.*`: radius, half_x, half_y, position (hand frame), stiffness, damping, friction.
    duration: s.
    effects: sizes by full name, such as "leader_slack.length" (see `effects`).
    controller: "sampled" (quantised encoder, zero-order hold) or "continuous".
    current_noise: A, of the current sensor at every tick, for the controller and the record.
    shift: s, how much later the hand runs than the clock of the record. crept: m, length that the
    leader has gained before (wire_creep). tolerance: of a step; longest: step in s.
    Raises ValueError on bad input, RuntimeError where Newton's method fails at the smallest step.
    """
    return trace(parameters, reference, **options)[0]
