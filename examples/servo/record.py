"""Makes recordings of a servo with other values than the one in servo.py, and a rough gear.

python record.py [FOLDER] [--load-friction 0.3] [--runs 4]

It shares no code with servo.py: everything is written at the shaft, dry friction holds exactly
(Karnopp's switch), values differ, and vary from run to run.
"""

import argparse
import math
from pathlib import Path

import numpy as np

DUTY, VOLTS, OHM = 8.0, 7.5, 2.45  # 1/rad, V, ohm
TURN = 0.91  # N m/A and V s/rad: of motor and gear
INERTIA, DRY, VISCOUS = 8.8e-3, 0.16, 0.044  # kg m2, N m, N m s/rad
WEIGHT, ANGLE = 0.41, 0.31  # N m, rad
STEP, LOGGED = 1e-4, 0.01  # s
COUNT, NOISE, AMPERES = 2.0 * math.pi / 4096.0, 1e-3, 0.01  # rad of the sensor, rad and A of noise


def steps(t):
    """Steps up and down [rad]."""
    return (0.0, 0.7, -0.5, 0.3, 0.0)[min(int(t / 0.8), 4)]


def sweep(t):
    """A slow swing that reverses where gravity pulls most [rad]."""
    return 1.2 * math.sin(1.4 * t) if t < 4.5 else 0.0


def run(asked, seconds, load_friction, rng):
    """Rows of time [s], command [rad], position [rad], current [A] as they are logged."""
    dry, weight = (x * (1.0 + 0.01 * rng.standard_normal()) for x in (DRY, WEIGHT))
    q = v = 0.0
    rows = []
    for k in range(round(seconds / STEP)):
        sent = math.floor((k - 0.5) * STEP / LOGGED) * LOGGED  # after the sensors are read
        target = asked(max(sent, 0.0))
        duty = min(max(DUTY * (target - q), -1.0), 1.0)
        current = (duty * VOLTS - TURN * v) / OHM
        pull = weight * math.sin(q + ANGLE)
        if k % round(LOGGED / STEP) == 0:
            rows.append((k * STEP, asked(k * STEP), q, current))
        free = TURN * current - pull
        hold = dry + load_friction * abs(pull)
        if v == 0.0 and abs(free) <= hold:
            continue
        side = math.copysign(1.0, v if v else free)
        new = v + STEP * (free - side * hold - VISCOUS * v) / INERTIA
        v = 0.0 if v and new * side < 0.0 else new
        q += STEP * v
    rows = np.array(rows)
    rows[:, 2] = COUNT * np.round((rows[:, 2] + NOISE * rng.standard_normal(len(rows))) / COUNT)
    rows[:, 3] += AMPERES * rng.standard_normal(len(rows))
    return rows


def main():
    """Write the recordings of each command."""
    parser = argparse.ArgumentParser(description="Record a servo whose gear rubs under load.")
    parser.add_argument("folder", nargs="?", type=Path, default=Path("recordings"))
    parser.add_argument("--load-friction", type=float, default=0.3, help="share of the load")
    parser.add_argument("--runs", type=int, default=4, help="of each command")
    parser.add_argument("--seed", type=int, default=1)
    asked = parser.parse_args()
    asked.folder.mkdir(parents=True, exist_ok=True)
    for k, (command, seconds) in enumerate(((steps, 4.0), (sweep, 5.0))):
        for number in range(asked.runs):
            rng = np.random.default_rng([asked.seed, k, number])
            rows = run(command, seconds, asked.load_friction, rng)
            path = asked.folder / f"{command.__name__}_{number + 1:02d}.csv"
            header = "time_s,reference_rad,position_rad,current_A"
            np.savetxt(path, rows, "%.9g", ",", header=header, comments="")


if __name__ == "__main__":
    main()
