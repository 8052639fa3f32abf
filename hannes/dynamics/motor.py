"""Brushed DC motor with inductance, behind the 19:1 reducer that winds the leader wire."""

from hannes.core.kernels.jit import kernel
from hannes.core.parameter import Parameter, group

FIT = "choice, fitted to Table II"

PARAMETERS = group(
    "motor",
    Parameter("torque_constant", 0.01808, "N m/A", (1e-4, 1), "k_t, equal to k_e", FIT),
    Parameter("resistance", 3.084, "ohm", (0.01, 100), "winding at rest temperature"),
    Parameter("inductance", 1.4e-4, "H", (1e-6, 0.1), "winding; L/R about 45 us"),
    Parameter("inertia", 3.31e-7, "kg m2", (1e-9, 1e-3), "rotor and reducer, motor side"),
    Parameter("dry_friction", 4.7e-3, "N m", (0, 0.1), "motor and gear, motor side", FIT),
    Parameter("friction_speed", 5.0, "rad/s", (0.01, 100), "width of the dry-friction tanh"),
    Parameter(
        "viscous_friction", 5.25e-7, "N m s/rad", (0, 1e-3), "motor and gear, motor side", FIT
    ),
) + group(
    "gear",
    Parameter("ratio", 19.0, "1", (1, 1000), "motor turns per output turn", "paper, section II.B"),
    Parameter("pulley_radius", 4.74e-3, "m", (5e-4, 0.05), "of the motor pulley", FIT),
)


@kernel
def current_rate(voltage, current, speed, resistance, torque_constant, inductance):
    """L di/dt = V - R i - k_e w, with k_e = k_t: returns di/dt [A/s]."""
    return (voltage - resistance * current - torque_constant * speed) / inductance


@kernel
def speed_rate(torque_constant, current, friction, load, inertia):
    """J dw/dt = k_t i - friction - load, all at the motor side: returns dw/dt [rad/s2]."""
    return (torque_constant * current - friction - load) / inertia
