"""The two nested controllers, motor side: position (rad) -> current (A) -> voltage -> duty.

Derivative action on the measured speed less a share of the reference's: `control.reference_share` 0
brakes all motion, 1 acts on the error's rate. Back calculation unwinds both integrals: the outer
one by the clipped part of the current demand, the inner one within current_gain / integral_gain.
"""

from math import floor, pi

from benchmarks.truth._jit import compiled


@compiled
def _clip(value, limit):
    return min(max(value, -limit), limit)


@compiled
def continuous(h, reference, position, current, integral, lag, inner):
    """Duty, and the rates of the position integral, the speed filter's lag and the inner volts."""
    error = reference - position
    speed = (position - h.control_reference_share * reference - lag) / h.control_speed_lag
    demand = h.control_position_gain * error + h.control_integral_gain * integral
    demand -= h.control_velocity_gain * speed
    allowed = _clip(demand, h.control_current_limit)
    miss = allowed - current
    wanted = h.control_current_gain * miss + inner
    duty = _clip(wanted / h.supply_voltage, 1.0)
    unwind = h.control_current_integral_gain / h.control_current_gain
    rate = h.control_current_integral_gain * miss + unwind * (duty * h.supply_voltage - wanted)
    return duty, error + (allowed - demand) / h.control_position_gain, speed, rate


@compiled
def encoder(h, shaft):
    """Output-shaft angle (rad) as the multi-turn magnetic encoder reports it."""
    step = 2.0 * pi / h.encoder_counts
    return step * floor(shaft / step + 0.5)


@compiled
def sampled(h, reference, position, current, memory):
    """Duty for the coming period; `memory`: integral, filtered speed, inner volts, last motion.

    As the firmware does it: difference, one-pole filter, forward sums with back calculation.
    """
    period = h.control_period
    error = reference - position
    motion = position - h.control_reference_share * reference
    fresh = (motion - memory[3]) / period
    memory[1] += h.control_speed_weight * (fresh - memory[1])
    memory[3] = motion
    demand = h.control_position_gain * error + h.control_integral_gain * memory[0]
    demand -= h.control_velocity_gain * memory[1]
    allowed = _clip(demand, h.control_current_limit)
    memory[0] += period * (error + (allowed - demand) / h.control_position_gain)
    miss = allowed - current
    memory[2] += period * h.control_current_integral_gain * miss
    wanted = h.control_current_gain * miss + memory[2]
    duty = _clip(wanted / h.supply_voltage, 1.0)
    memory[2] += duty * h.supply_voltage - wanted
    return duty
