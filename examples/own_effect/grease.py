"""An effect of one's own: thick grease in the gear of the hand. See grasp.toml and compare.py."""

from hannes import Effect, Parameter, Term, kernel


@kernel
def drag(motor_speed, coefficient):
    """Friction on the motor [N m], against its motion, by its speed [rad/s]."""
    return coefficient * motor_speed * abs(motor_speed)


EFFECT = Effect(
    name="thick_grease",
    meaning="Grease in the gear resists with the square of the motor's speed.",
    equation="T_friction += coefficient w |w|",
    source="a choice for this example",
    parameters=(
        Parameter("coefficient", 0.0, "N m s^2/rad^2", (0.0, 1e-6), "of the drag", off=0.0),
    ),
    terms=(Term(drag, writes=("gear_friction",), unit="N m"),),
)
