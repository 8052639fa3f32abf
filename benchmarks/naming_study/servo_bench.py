"""A bench for the truth's geared servo: commands, scatter, sensors, a campaign.

Three commands, four runs of each, logged at 100 Hz from a potentiometer, whose noise covers the
counts of its converter, and a noisy current sensor.
Every value of the machine scatters by 2 %, dry and viscous friction by 0.5 % from run to run. The
analyst says 3 %, 1 %, and 0.2 ms of the start of a run.
"""

import json
import shutil
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from benchmarks.truth import geared_servo as truth

EXAMPLE = Path(__file__).parents[2] / "examples" / "servo"
RUNS = 4
PERIOD = 0.01  # s, of the log
COUNT, NOISE, AMPERES = 2.0 * np.pi / 4096.0, 1e-3, 0.02  # rad, rad, A
SCATTER, RUN_SCATTER, START = 0.02, 0.005, 2e-4  # relative, relative, s
STREAM = 43  # of random numbers

CAMPAIGN = """plant = "servo:Servo"
[diagnose]
scatter = "3 %"
run_scatter = "1 %"
start_time = "0.2 ms"
"""


def commands() -> dict[str, np.ndarray]:
    """Asked positions [rad], one each PERIOD: steps that clip the duty, and a slow swing.

    Steps are short, so that a diagnosis, which has 115 bins a channel, has one for each sample.
    """
    up = np.repeat([0.0, 0.7, 0.6, 0.1, 0.1], [15, 35, 25, 35, 5])
    down = np.repeat([0.0, -0.8, -0.7, 0.3, 0.35], [15, 35, 20, 30, 15])
    time = PERIOD * np.arange(450)
    late = np.sin(4.5) + 0.15 * np.sin(6.0 * time - 18.0)
    return {"up": up, "down": down, "swing": np.where(time < 3.0, np.sin(1.5 * time), late)}


def clock(command: np.ndarray) -> np.ndarray:
    """Times [s] of a command's samples, shape (n,)."""
    return PERIOD * np.arange(command.size)


def run(
    values: Mapping[str, float], command: np.ndarray, start: float = 0.0
) -> dict[str, np.ndarray]:
    """Position [rad] and current [A] of the truth, as they are; start: lateness of the command."""
    time = clock(command)
    asked = np.array([time + start, command])
    asked[0, 0] = 0.0
    found = truth.simulate(values, time, asked)
    return {name: found[name] for name in ("position", "current")}


def machine(rng: np.random.Generator, hidden: Mapping[str, float]) -> dict[str, float]:
    """One servo of many, and what is hidden in it, by the truth's names [SI]."""
    scattered = {
        name: size * (1.0 + SCATTER * rng.standard_normal()) for name, size in truth.SERVO.items()
    }
    scattered["angle"] = truth.SERVO["angle"] + SCATTER * rng.standard_normal()
    return {**scattered, "limit": truth.SERVO["limit"], **hidden}


def make(folder: Path, seed: int, hidden: Mapping[str, float]) -> Path:
    """Write a campaign into a folder, the servo's plant beside it; returns its TOML file."""
    rng = np.random.default_rng([seed, STREAM])
    values, lines = machine(rng, hidden), [CAMPAIGN]
    folder.mkdir(parents=True)
    for file in EXAMPLE.glob("*.py"):
        shutil.copy(file, folder)
    for name, command in commands().items():
        for number in range(RUNS):
            rubbed = {
                each: values[each] * (1.0 + RUN_SCATTER * rng.standard_normal())
                for each in ("dry", "viscous")
            }
            found = run({**values, **rubbed}, command)
            noisy = found["position"] + NOISE * rng.standard_normal(command.size)
            seen = COUNT * np.round(noisy / COUNT)
            drawn = found["current"] + AMPERES * rng.standard_normal(command.size)
            table = np.column_stack((clock(command), command, seen, drawn))
            file = f"{name}_{number}.csv"
            header = "time_s,reference_rad,position_rad,current_A"
            np.savetxt(folder / file, table, "%.9g", ",", header=header, comments="")
            lines.append(f'[[recording]]\nfile = {json.dumps(file)}\ncondition = "{name}"\n')
    campaign = folder / "campaign.toml"
    campaign.write_text("".join(lines), encoding="utf-8")
    return campaign
