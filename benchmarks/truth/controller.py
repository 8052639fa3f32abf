"""The two nested controllers, motor side: position (rad) -> current (A) -> voltage -> duty.

Derivative action on the measured speed less a share of the reference's
(`position_pid.reference_share`): 0 brakes all motion, 1 acts on the error's rate. Back calculation
unwinds both integrals: the outer one by the clipped part of the current demand, the inner one by
the clipped volts, within a time of proportional / integral gain.
"""

from math import floor, pi

from benchmarks.truth._jit import compiled


@compiled
def _clip(value, limit):
    return min(max(value, -limit), limit)


@compiled
def rounded(value, step):
    """The nearest multiple of step; the value itself where step is 0."""
    return step * floor(value / step + 0.5) if step > 0.0 else value


@compiled
def continuous(h, reference, position, current, integral, lag, inner):
    """Duty, and the rates of the position integral, the speed filter's lag and the inner volts."""
    error = reference - position
    speed = (position - h.position_pid_reference_share * reference - lag) / h.position_pid_filter
    demand = h.position_pid_proportional * error + h.position_pid_integral * integral
    demand -= h.position_pid_derivative * speed
    allowed = _clip(demand, h.position_pid_limit)
    miss = allowed - current
    wanted = h.current_pid_proportional * miss + inner
    duty = _clip(wanted / h.supply_voltage, 1.0)
    unwind = h.current_pid_integral / h.current_pid_proportional
    rate = h.current_pid_integral * miss + unwind * (duty * h.supply_voltage - wanted)
    return duty, error + (allowed - demand) / h.position_pid_proportional, speed, rate


@compiled
def encoder(h, shaft):
    """Output-shaft angle (rad) as the multi-turn magnetic encoder reports it."""
    return rounded(shaft, 2.0 * pi / 2.0**h.encoder_bits)


@compiled
def sampled(h, reference, position, current, memory):
    """Duty for the coming period; `memory`: integral, filtered speed, inner volts, last motion.

    As the firmware does it: difference, one-pole filter, forward sums with back calculation.
    """
    period = h.controller_period
    error = reference - position
    motion = position - h.position_pid_reference_share * reference
    fresh = (motion - memory[3]) / period
    memory[1] += h.controller_speed_weight * (fresh - memory[1])
    memory[3] = motion
    demand = h.position_pid_proportional * error + h.position_pid_integral * memory[0]
    demand -= h.position_pid_derivative * memory[1]
    allowed = _clip(demand, h.position_pid_limit)
    memory[0] += period * (error + (allowed - demand) / h.position_pid_proportional)
    miss = allowed - current
    memory[2] += period * h.current_pid_integral * miss
    wanted = h.current_pid_proportional * miss + memory[2]
    duty = _clip(wanted / h.supply_voltage, 1.0)
    memory[2] += duty * h.supply_voltage - wanted
    return duty
