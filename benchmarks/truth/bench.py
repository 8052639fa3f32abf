"""What the bench logs of a run: sensors with noise and resolution, as a recording."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from benchmarks.truth.protocol import Condition
from hannes.core.recording.recording import Recording

# Standard deviation of white noise, and resolution. The encoder resolves 2^-12 turn without noise.
CURRENT, CURRENT_STEP = 10e-3, 5e-3  # A; the controller sees the same samples
SUPPLY, SUPPLY_STEP = 5e-3, 4e-3  # V
FORCE, FORCE_STEP = 0.2, 0.1  # N, of both force channels
FORCES = ("force_N", "sensor_N")
MAKER = "# Made by benchmarks.truth, a second implementation of the hand; not measured.\n"


def logged(
    ran: Mapping[str, np.ndarray],
    condition: Condition,
    channels: tuple[str, ...],
    hand: str,
    rng: np.random.Generator,
) -> Recording:
    """The recording of a run; `hand`: TOML of the hand that the bench believes it has.

    It calls itself measured, as what an analyst gets is; its experiment's text says who made it.
    """
    names = (*channels, *condition.also, *(FORCES if condition.sensor else ()))
    columns = {"time_s": ran["time_s"], **{name: ran[name] for name in names}}
    draws = rng.standard_normal((3, ran["time_s"].size))
    noisy = {"supply_V": (SUPPLY, SUPPLY_STEP), **dict.fromkeys(FORCES, (FORCE, FORCE_STEP))}
    for row, (name, (spread, step)) in enumerate(noisy.items()):
        if name in columns:
            columns[name] = step * np.round((columns[name] + spread * draws[row]) / step)
    split = {column: column.rpartition("_")[::2] for column in columns}
    return Recording(
        {split[column][0]: values for column, values in columns.items()},
        dict(split.values()),
        plant="hand",
        experiment=experiment_text(condition),
        hand=hand,
    )


def experiment_text(condition: Condition) -> str:
    """The run as an experiment that hannes can simulate, with what its bench knows of it."""
    points = ", ".join(f'["{t!r} s", "{angle!r} rad"]' for t, angle in condition.points)
    lines = [
        f'title = "{condition.name}"',
        'hand = "hannes"',
        f'duration = "{condition.duration!r} s"',
        'sampling = "1 kHz"',
        'controller = "sampled"',
        "",
        "[reference]",
        'kind = "ramp"',
        f"points = [{points}]",
    ]
    return MAKER + "\n".join([*lines, *_object_lines(condition)]) + "\n"


def _object_lines(condition: Condition) -> list[str]:
    thing: Mapping[str, Any] | None = condition.thing
    if thing is None:
        return []
    units = {"stiffness": "N/m", "damping": "N s/m", "friction": "1"}
    material = [f'{key} = "{thing[key]!r} {unit}"' for key, unit in units.items() if key in thing]
    lines = ["", "[object]", f'shape = "{thing["shape"]}"']
    if "radius" in thing:
        lines.append(f'radius = "{thing["radius"]!r} m"')
    if "x" in thing:
        lines.append(f'position = ["{thing["x"]!r} m", "{thing["y"]!r} m", "{thing["z"]!r} m"]')
    if material:
        lines.append(f"material = {{ {', '.join(material)} }}")
    return [*lines, f"sensor = {str(condition.sensor).lower()}"]
