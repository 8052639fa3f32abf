"""Load-dependent gear friction: teeth rub the harder the more torque they carry.

    T_friction += coefficient |T_load| tanh(w / w_s),  T_load = r_p T_L / N

w: motor speed; w_s: `motor.friction_speed`; all at the motor's side.
Source: Armstrong & Canudas de Wit (1995). Range: ground spur gears (0.3 % a stage) to worn
planetary stages (20 %).
"""

from benchmarks.truth._jit import compiled
from benchmarks.truth.size import Size

SIZES = {"coefficient": Size("1", 0.003, 0.2)}


@compiled
def lost(h, load):
    """Friction level (N m) that a load (N m) adds."""
    return h.gear_load_coefficient * abs(load)
