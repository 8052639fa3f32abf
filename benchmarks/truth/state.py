"""Where each quantity lies in the state vector (SI, motor side), and how large it may get.

Solved for (UNKNOWNS): speeds and current. All other quantities follow from them within a stage,
each by its own relation z = start + gain z': positions from speeds, and the inner variables of
controllers, sensors, springs and contacts, whose rates are a - b z (see `laws.held`).
"""

import numpy as np

ANGLE, SPEED = 0, 10  # joints: 2 finger + (0 MCP, 1 PIP)
CART, CART_SPEED = 20, 22
MOTOR, MOTOR_SPEED, CURRENT = 24, 25, 26
INTEGRAL, LAG, VOLTS = 27, 28, 29  # continuous controller; at rest where it is sampled
SHAFT, SHAFT_SPEED = 30, 31  # output shaft
SENSED, FORCE_READING, FACE = 32, 33, 34  # filtered current, force and face reading
CREPT = 35  # length that the leader has gained
HYSTERESIS, DENT = 36, 46  # springs of the joints; object under the phalanges (2 finger + link)
WORK = 56  # of friction of motor and gear, were they cold
SIZE = 57

# Each unknown and the position that it moves (-1: none); with backlash, also the shaft's.
UNKNOWNS = np.array(
    [
        *((SPEED + k, ANGLE + k) for k in range(10)),
        (CART_SPEED, CART),
        (CART_SPEED + 1, CART + 1),
        (MOTOR_SPEED, MOTOR),
        (CURRENT, -1),
        (SHAFT_SPEED, SHAFT),
    ]
)

SCALE = np.ones(SIZE)
SCALE[SPEED : SPEED + 10] = 10.0  # rad/s
SCALE[CART : CART + 2] = 1e-2  # m
SCALE[CART_SPEED : CART_SPEED + 2] = 0.1  # m/s
SCALE[MOTOR], SCALE[MOTOR_SPEED], SCALE[SHAFT], SCALE[SHAFT_SPEED] = 100.0, 300.0, 5.0, 16.0
# Positions whose error is watched beside that of the unknowns.
WATCHED = np.array([*range(ANGLE, ANGLE + 10), CART, CART + 1, MOTOR])
