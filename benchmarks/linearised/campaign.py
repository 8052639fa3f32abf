"""Sound campaigns drawn about the truth: a hand, its joints, its runs, and noise, all linear."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from benchmarks.guarding.plan import SPREAD
from benchmarks.linearised.tangent import CONDITIONS, Tangent, nominal, tangent
from benchmarks.truth import bench
from benchmarks.truth.campaign import HAND, JOINTS, RUN, SENSORS, SHIPPED
from benchmarks.truth.noise import RATE, current_noise
from benchmarks.truth.parameters import FINGERS, GEOMETRY, OWN
from benchmarks.truth.protocol import PROTOCOLS, Condition
from benchmarks.truth.scatter import EXACT, PLACES, RUN_PLACES, RUN_TO_RUN, normal
from hannes.core.io.atomic_files import write_text
from hannes.core.recording.recording import Recording

PLANT = "benchmarks.linearised.plant:LinearHand"
TICKS = 2.0**12  # of the encoder, a turn
NOTHING: Mapping[str, float] = {}
Moved = dict[str, float]  # by full name: distance from the nominal value, SI


def hand(seed: int) -> Moved:
    """How far a hand is from the nominal one, by the laws of `benchmarks.truth.scatter`."""
    rng, joints = np.random.default_rng([seed, HAND]), np.random.default_rng([seed, JOINTS])
    found = {}
    for name, value in nominal().items():
        finger, _, what = name.partition(".")
        z = float(normal(rng, ()))
        if f"finger_share.{what}" in OWN and finger in FINGERS:
            found[name] = SPREAD.finger * float(normal(joints, ()))
        elif name in PLACES:
            found[name] = SPREAD.hand * PLACES[name] * z
        elif not _exact(name):
            found[name] = SPREAD.hand * value * z
    return found


def _exact(name: str) -> bool:
    finger, _, what = name.partition(".")
    return (GEOMETRY.get(what, "") if finger in FINGERS else name).startswith(EXACT)


def run(rng: np.random.Generator) -> tuple[Moved, float]:
    """How far a run is from the hand, and how late it starts (s)."""
    found = {}
    for name, value in nominal().items():
        z = SPREAD.run * float(normal(rng, ()))
        if name in RUN_PLACES:
            found[name] = RUN_PLACES[name] * z
        elif share := RUN_TO_RUN.get(name.partition(".")[2], 0.0):
            found[name] = share * value * z
    return found, SPREAD.timing * float(normal(rng, ()))


def write(
    seed: int, bandwidth: float | None, folder: Path, hidden: Mapping[str, float] = NOTHING
) -> Path:
    """The campaign file of a hand, recordings beside it; bandwidth: of the noise (Hz).

    hidden: amplitudes of effects without a shape, by full name, SI; a sound hand has none
    """
    own = {**hand(seed), **hidden}
    lines = [f'plant = "{PLANT}"', 'out = "diagnosis"', *SPREAD.lines]
    for k, condition in enumerate(PROTOCOLS["poor"].runs):
        moved, late = run(np.random.default_rng([seed, RUN, k]))
        here = {n: own.get(n, 0.0) + moved.get(n, 0.0) for n in own.keys() | moved.keys()}
        noise = np.random.default_rng([seed, SENSORS, k])
        name = f"{k + 1:02d}_{condition.stem}.h5"
        _recording(condition, here, late, noise, bandwidth).write(folder / name)
        lines += ["", "[[recording]]", f'file = "{name}"', f'condition = "{condition.name}"']
    write_text(folder / "campaign.toml", "\n".join(lines) + "\n")
    return folder / "campaign.toml"


def _recording(
    condition: Condition,
    moved: Mapping[str, float],
    late: float,
    rng: np.random.Generator,
    bandwidth: float | None,
) -> Recording:
    channels = sensed(_channels(tangent(condition.name), moved, late), rng, bandwidth)
    time = np.arange(channels["position"].size) / RATE
    times, angles = np.array(CONDITIONS[condition.name].points).T
    channels = {"time": time, "reference": np.interp(time, times, angles), **channels}
    units = {"time": "s", "reference": "rad", "position": "rad", "current": "A",
             "force": "N", "sensor": "N"}  # fmt: skip
    text = bench.experiment_text(condition).replace("sampled", "continuous")
    used = {name: units[name] for name in channels}
    return Recording(channels, used, plant="hand", experiment=text, hand=SHIPPED)


def _channels(one: Tangent, moved: Mapping[str, float], late: float) -> dict[str, np.ndarray]:
    columns = {**one.values, **one.effects}
    row = one.base + sum(size * columns[name] for name, size in sorted(moved.items()))
    pieces = np.split(row, len(one.channels))
    return {
        name: piece - late * np.gradient(piece) * RATE
        for name, piece in zip(one.channels, pieces, strict=True)
    }


def sensed(
    channels: Mapping[str, np.ndarray], rng: np.random.Generator, bandwidth: float | None
) -> dict[str, np.ndarray]:
    """As the bench's sensors read them; rounding is noise as wide as a step, and linear so."""
    found = {name: samples.copy() for name, samples in channels.items()}
    found["current"] += current_noise(rng, found["current"].size, bandwidth)
    steps = {"position": 2.0 * np.pi / TICKS, "current": bench.CURRENT_STEP}
    for name in set(found) & {"force", "sensor"}:
        found[name] += bench.FORCE * rng.standard_normal(found[name].size)
        steps[name] = bench.FORCE_STEP
    return {name: x + steps[name] * rng.uniform(-0.5, 0.5, x.size) for name, x in found.items()}
