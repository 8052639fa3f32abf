"""Places of the numbers that the hand's sampled firmware keeps from tick to tick."""

DUTY = 0  # of the PWM, -1 to 1
POSITION_INTEGRAL = 1  # of the outer PID [A]
CURRENT_INTEGRAL = 2  # of the inner PID [V]
FILTERED_SPEED = 3  # rad/s, motor side
LAST_ANGLE = 4  # rad, motor side
LAST_CURRENT = 5  # A
CURRENT_REFERENCE = 6  # A
PROBED_SHAFT = 7  # rad, output side, before any delay of the sensors
PROBED_CURRENT = 8  # A, likewise
READING_AGE = 9  # s, of what the next tick reads
MEMORY = 10  # numbers in all
