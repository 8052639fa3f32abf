"""The two nested controllers, motor side: position (rad) -> current (A) -> voltage -> duty.

Derivative action on the measured speed. Back calculation unwinds both integrals: the outer one by
the clipped part of the current demand, the inner one by the clipped volts, within a time of
proportional / integral gain.
"""

from math import floor, pi

from benchmarks.truth._jit import compiled
from benchmarks.truth.effects import error_dead_band, thermal_derating
from benchmarks.truth.laws import held
from benchmarks.truth.state import INTEGRAL, LAG, VOLTS


@compiled
def _clip(value, limit):
    return min(max(value, -limit), limit)


@compiled
def rounded(value, step):
    """The nearest multiple of step; the value itself where step is 0."""
    return step * floor(value / step + 0.5) if step > 0.0 else value


@compiled
def _unwound(start, gain, error, rest, integral_gain, limit, unwind):
    """Integral z of `error` with back calculation, its rate, and the clipped sum of both parts.

    rest: what joins integral_gain z in the sum; unwind: rate of z per clipped part of the sum.
    The rate is linear in z on either side of the limit, so trying both finds the implicit z.
    """
    a, b = error, 0.0
    z = held(start, gain, a, b)
    total = rest + integral_gain * z
    allowed = _clip(total, limit)
    if allowed != total:
        a, b = error + unwind * (allowed - rest), unwind * integral_gain
        z = held(start, gain, a, b)
    return z, a - b * z, allowed


@compiled
def continuous(h, reference, position, current, start, gain, y, dy):
    """Duty; writes position integral, speed filter and the inner integral's volts."""
    y[LAG] = held(start[LAG], gain, position / h.position_pid_filter, 1.0 / h.position_pid_filter)
    dy[LAG] = speed = (position - y[LAG]) / h.position_pid_filter
    error = error_dead_band.used(h, reference - position)
    rest = h.position_pid_proportional * error - h.position_pid_derivative * speed
    y[INTEGRAL], dy[INTEGRAL], allowed = _unwound(
        start[INTEGRAL],
        gain,
        error,
        rest,
        h.position_pid_integral,
        h.position_pid_limit,
        1.0 / h.position_pid_proportional,
    )
    miss = allowed - current
    y[VOLTS], dy[VOLTS], volts = _unwound(
        start[VOLTS],
        gain,
        h.current_pid_integral * miss,
        h.current_pid_proportional * miss,
        1.0,
        h.supply_voltage,
        h.current_pid_integral / h.current_pid_proportional,
    )
    return volts / h.supply_voltage


@compiled
def encoder(h, shaft):
    """Output-shaft angle (rad) as the multi-turn magnetic encoder reports it."""
    return rounded(shaft, 2.0 * pi / 2.0**h.encoder_bits)


@compiled
def sampled(h, reference, position, current, memory):
    """Duty for the coming period; `memory`: integral, filtered speed, inner volts, last position,
    heat (A2 s).

    As the firmware does it: difference, one-pole filter; integrals act first and are summed after.
    """
    period = h.controller_period
    error = error_dead_band.used(h, reference - position)
    memory[1] += h.controller_speed_weight * ((position - memory[3]) / period - memory[1])
    memory[3] = position
    demand = h.position_pid_proportional * error + h.position_pid_integral * memory[0]
    demand -= h.position_pid_derivative * memory[1]
    allowed = _clip(demand, thermal_derating.limit(h, memory[4]))
    memory[4] += period * current * current
    memory[0] += period * (error + (allowed - demand) / h.position_pid_proportional)
    miss = allowed - current
    wanted = h.current_pid_proportional * miss + memory[2]
    volts = _clip(wanted, h.supply_voltage)
    cut = (volts - wanted) / h.current_pid_proportional
    memory[2] += period * h.current_pid_integral * (miss + cut)
    return volts / h.supply_voltage
