"""Effects that a hand of the truth can hide: the catalogue's, written a second time, and others.

One file each: equation, source, parameters and their physical range. SI units; motor, friction and
load at the motor's side; q closing positive; a size of 0 is exactly no effect. `T += ...` adds to
the base model's term of that name. In the table an asterisk marks what tells where or how fast the
effect acts, not how much of it there is; such a parameter has a default.

Catalogue (the library knows each by this name):

==========================  =======  ===============  ===========================================
parameter                   unit     range (default)  equation
==========================  =======  ===============  ===========================================
leader_slack.length         m        2e-4 .. 8e-3     s_L = r_p phi - length - (2xA + 2xB + l_th)
wire_compliance.leader      m/N      1.5e-7 .. 2e-5   1/k_leader += leader
wire_compliance.follower    m/N      1.5e-7 .. 2e-5   1/k_follower += follower
capstan.friction            1        0.003 .. 0.15    T_out = T_in exp(-friction pi tanh(v/5mm/s)),
                                                      three leader pulleys, two follower pulleys
gear_load.coefficient       1        0.003 .. 0.2     T_friction += coefficient |r_p T_L/N| way
direction_friction.dry      1        -0.4 .. 0.4      T_friction += dry T_dry |way|
direction_friction.viscous  1        -0.4 .. 0.4      T_friction += viscous f |w|
stribeck.torque             N m      2e-4 .. 5e-3     T_friction += sqrt(2e) torque u exp(-u^2),
stribeck.speed *            rad/s    5 .. 60 (20)     u = w / (sqrt(2) speed)
gear_backlash.gap           rad      2e-3 .. 0.05     shaft (pulley, encoder) free within +-gap/2
                                                      of th/N, in the middle at rest
torque_ripple.amplitude     N m      1e-4 .. 3e-3     J w' += amplitude sin(cycles th + phase)
torque_ripple.cycles *      1        1 .. 12 (4)      periods in a motor turn
torque_ripple.phase *       rad      -3.2 .. 3.2 (0)
winding_heating.rise        K        5 .. 100         R (1 + 3.93e-3 rise), k_t (1 - 1.1e-3 rise)
supply_sag.resistance       ohm      0.02 .. 1.5      V_bus = V_0 - resistance duty i
pwm_dead_band.width         1        0.002 .. 0.08    duty_out = duty - clip(duty, -width, width)
spring_error.share          1        -0.4 .. 0.4      T_open += share (preload + k (q - q_rest))
spring_hysteresis.share     1        0.02 .. 0.4      T_open += share (preload + k (q - q_rest)) z,
spring_hysteresis.width *   rad      0.01 .. 0.2      z' = (q' - |q'| z) / width, each joint; z(0)
                            (0.05)                    = 0
hunt_crossley.exponent      1        0.05 .. 0.8      F = k x (x/1mm)^exponent (1 + dissipation x')
hunt_crossley.dissipation   s/m      0.1 .. 3             + beta x' ramp(x)
viscoelastic_object.share   1        0.05 .. 1.5      F = k (x - d) + beta x' ramp(x), never < 0;
viscoelastic_object.time *  s        0.02 .. 2        d' = (share max(0, x - d) - d) / time, each
                            (0.15)                    phalanx; d(0) = 0
object_misplacement.x       m        -8e-3 .. 8e-3    object.x += x
object_misplacement.y       m        -8e-3 .. 8e-3    object.y += y
current_offset.offset       A        -0.2 .. 0.2      i_measured += offset
current_gain.error          1        -0.15 .. 0.15    i_measured += error i
current_lag.time            s        1e-4 .. 1e-2     time m' = i - m, i_measured = m
force_lag.time              s        1e-3 .. 0.2      time m' = F - m, logged force and sensor = m
command_delay.time          s        1e-4 .. 1e-2     reference used at t is that of t - time
measurement_delay.time      s        1e-4 .. 5e-3     position and current told at t are those of
                                                      t - time, to the controller and to the log
==========================  =======  ===============  ===========================================

with way = tanh(w / motor.friction_speed). Measured current passes lag, gain, offset, delay in this
order; then noise and resolution. The current sensor's effects reach the controller and the log.

Outside (no catalogue has them):

==========================  =======  ===============  ===========================================
friction_step.torque        N m      2e-3 .. 0.06     joint friction += torque step(q - angle)
friction_step.angle *       rad      0.3 .. 1.2 (.5)      tanh(q' / (w_bf/10)) at one joint,
friction_step.joint *       1        0 .. 9 (2)           step over 0.02 rad
nonlinear_spring.cubic      N m/rad3 3e-3 .. 0.08     T_open += cubic (q - q_rest)^3
eccentric_pulley.share      1        0.01 .. 0.15     lever r_p (1 + share cos(phi + phase))
eccentric_pulley.phase *    rad      -3.2 .. 3.2 (0)
jammed_finger.lost          1        0.5 .. 0.95      closing stops at q_end - lost (q_end - q_rest)
jammed_finger.finger *      1        0 .. 4 (1)           of one finger
wire_creep.rate             m/(N s)  1e-7 .. 1e-5     slack' = rate T_L, carried from run to run
==========================  =======  ===============  ===========================================
"""

from benchmarks.truth.effects import (
    capstan,
    command_delay,
    current_gain,
    current_lag,
    current_offset,
    direction_friction,
    eccentric_pulley,
    force_lag,
    friction_step,
    gear_backlash,
    gear_load,
    hunt_crossley,
    jammed_finger,
    leader_slack,
    measurement_delay,
    nonlinear_spring,
    object_misplacement,
    pwm_dead_band,
    spring_error,
    spring_hysteresis,
    stribeck,
    supply_sag,
    torque_ripple,
    viscoelastic_object,
    winding_heating,
    wire_compliance,
    wire_creep,
)

CATALOGUE = (
    leader_slack,
    wire_compliance,
    capstan,
    gear_load,
    direction_friction,
    stribeck,
    gear_backlash,
    torque_ripple,
    winding_heating,
    supply_sag,
    pwm_dead_band,
    spring_error,
    spring_hysteresis,
    hunt_crossley,
    viscoelastic_object,
    object_misplacement,
    current_offset,
    current_gain,
    current_lag,
    force_lag,
    command_delay,
    measurement_delay,
)
OUTSIDE = (friction_step, nonlinear_spring, eccentric_pulley, jammed_finger, wire_creep)

# Full name, as in "leader_slack.length" -> its declaration.
SIZES = {
    f"{effect.__name__.rpartition('.')[2]}.{name}": size
    for effect in (*CATALOGUE, *OUTSIDE)
    for name, size in effect.SIZES.items()
}
