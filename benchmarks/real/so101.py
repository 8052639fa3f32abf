"""SO-101: what a diagnosis finds in two joints, on motions that nothing was fitted to.

One joint is one machine: the geared servo of examples/servo, whose base (P control with a clipped
duty, back EMF, Coulomb and viscous friction, gravity where the joint carries it, armature) is
refitted. Diagnoses by hold-out follow each other, each with what was found before in its model,
until nothing more is named. All models are fitted to the same stretches of the motions in role fit,
and in the end to those in role select as well. They are judged on whole motions in role show, run
from the command alone: RMS of position.

The stretches leave out what no servo of this kind follows, seen in the motions that are fitted: the
chirp beyond 1 Hz, where the jaw runs at its greatest speed throughout, and the single-joint motion
of the elbow, which an obstacle at 0.78 rad holds twice (its current rises to 1.1).
"""

import os
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.harness import Row, must_show
from benchmarks.real.black_box import ARX, DelayedLag
from hannes.campaigns.campaign import Campaign, Entry
from hannes.campaigns.convert import convert
from hannes.campaigns.segments import Segment, noise_floors
from hannes.commands.diagnose import diagnose
from hannes.core.errors import ComputationFailed, MissingRecording
from hannes.core.ranged import ranged
from hannes.core.recording.recording import Recording
from hannes.identification.holdout.least_squares import WeightedResidual, fit
from hannes.plants.protocol import find_plant
from hannes.plants.with_effects import PlantWithEffects
from hannes.simulation.catalogue import effects

EXAMPLE = Path(__file__).parents[2] / "examples" / "servo"
# Motion -> role, and the stretch of it that is fitted [s].
PARTS_FITTED: Mapping[str, tuple[str, float, float]] = {
    "chirp_sweep": ("fit", 5.0, 25.0),
    "multisine": ("fit", 20.0, 40.0),
    "prbs_excitation": ("fit", 0.0, 20.0),
    "slow_precision": ("fit", 15.0, 40.0),
    "step_response": ("select", 20.0, 45.0),
    "fast_transitions": ("select", 8.0, 30.0),
}
SHOWN = ("backlash_detection", "friction_gravity", "gripper_cycles", "hold_under_gravity")
MOVES = 0.02  # rad, of a command that moves its joint
ROUNDS = 2  # diagnoses, at most
LEAST_GAIN, TIMES_FLOOR = 0.3, 1.5
JAW_RANGE = 2.324  # rad: a count of its 12-bit encoder is 0.00066 of its range

# Of the servo, from its data sheet (STS3215, 7.4 V), else a guess.
NOMINAL = {
    "control.limit": 0.97, "motor.torque_constant": 4.5e-3, "motor.inertia": 3e-7,
    "motor.dry_friction": 1.5e-3, "motor.viscous_friction": 2e-6, "gear.ratio": 345.0,
}  # fmt: skip
FREE = {
    "control.gain": 4.0, "control.limit": 0.2, "motor.torque_constant": 3e-3,
    "motor.inertia": 3e-7, "motor.dry_friction": 1e-3, "motor.viscous_friction": 2e-6,
}  # fmt: skip
GRAVITY = {"gravity.torque": 0.5, "gravity.angle": 0.5}


@dataclass(frozen=True)
class Joint:
    """One joint of the arm. place: in a row of the log, from 1; turns: rad in a unit of the log"""

    name: str
    place: int
    turns: float
    weighted: bool  # gravity


JOINTS = (Joint("Elbow", 3, 1.0, True), Joint("Jaw", 6, JAW_RANGE, False))
MAPPING = """plant = "{plant}"
[time]
column = "timestamp"
unit = "us"
from_zero = true
[files.control]
replace = "_state_motor"
by = "_control"
time = {{column = "timestamp", unit = "us"}}
[channels.reference]
from = "control"
column = "positions"
index = {place}
unit = "rad"
scale = {turns}
[channels.position]
column = "positions"
index = {place}
unit = "rad"
scale = {turns}
"""


def joint_plant(joint: Joint) -> PlantWithEffects:
    """The servo of the example as this joint; by hold-out, as nothing of it is known well.

    It expects nothing of its channels: a joint that sticks does not follow its command in time.
    """
    servo = type(find_plant("servo:Servo", EXAMPLE))
    own = {"free": FREE | (GRAVITY if joint.weighted else {}), "uncertain": {}, "step": 4e-3,
           "judged": ("position",), "expected": {}}  # fmt: skip
    made = type("JointServo", (servo,), own)()
    weight = {"gravity.torque": -0.8, "gravity.angle": 1.7} if joint.weighted else {}
    return made.with_values({**NOMINAL, **(weight or {"gravity.torque": 0.0})})


def campaign(joint: Joint, folder: Path, quick: bool = False) -> Campaign:
    """Recordings of one joint, read by a mapping: stretches, and whole motions to show."""
    mapping = folder / f"so101_{joint.name.lower()}.toml"
    plant = joint_plant(joint)
    mapping.parent.mkdir(parents=True, exist_ok=True)
    text = MAPPING.format(plant="hand", place=joint.place, turns=joint.turns)
    mapping.write_text(text, encoding="utf-8")
    entries = []
    for motion in (*PARTS_FITTED, *SHOWN):
        made = convert([measured() / f"{motion}_state_motor.csv.gz"], mapping)[0].recording
        role, begin, end = PARTS_FITTED.get(motion, ("show", 0.0, np.inf))
        end = min(end, begin + 8.0) if quick else end
        recording = _stretch(made, begin, end)
        if np.ptp(recording["reference"]) > MOVES:
            entries.append(Entry(motion, recording, motion, role))
    known = {**effects(), **plant.catalogue}
    ranges: Mapping[str, tuple[float, float]] = plant.ranges
    return Campaign(plant, plant, tuple(entries), folder / joint.name,
                    {name: ranged(each, ranges) for name, each in known.items()},
                    f"SO-101, {joint.name}", "servo")  # fmt: skip


def measured() -> Path:
    """The folder of the recordings; MissingRecording where there is none."""
    folder = Path(os.environ.get("HANNES_MEASURED", "nowhere")) / "so101"
    if not folder.is_dir():
        raise MissingRecording(
            "the recordings so101/*.csv.gz are missing: set HANNES_MEASURED to the folder above "
            "so101, filled from github.com/isaac-sim2real/sage at commit 4ffd2627"
        )
    return folder


def _stretch(recording: Recording, begin: float, end: float) -> Recording:
    kept = (recording.time >= begin) & (recording.time < end)
    units = {"time": "s", "reference": "rad", "position": "rad"}
    cut = {name: recording[name][kept] for name in units}
    return Recording(cut | {"time": cut["time"] - cut["time"][0]}, units)


def figures(folder: Path, quick: bool) -> tuple[list[Row], list[Row]]:
    """What each model leaves of each joint's show motions, and what must be shown of it."""
    rows: list[Row] = []
    bounds: list[Row] = []
    for joint in JOINTS:
        made = campaign(joint, folder, quick)
        found = _found(made)
        models = _models(made, found)
        rows += _rows(joint, made, models)
        bounds += _bounds(joint, made, models)
    return rows, bounds


def _found(made: Campaign) -> list[str]:
    """Names of what diagnoses find one after another; pages and places go to the user."""
    names: list[str] = []
    for number in range(ROUNDS):
        plant = made.plant.with_effects(*(made.effects[name] for name in names))
        result = diagnose(replace(made, plant=plant), out=made.out / f"round_{number + 1}")
        print(f"{made.title}: {result.verdict.sentence}", file=sys.stderr)
        if not result.verdict.effects:
            break
        names += result.verdict.effects
    for place in result.verdict.where[:2]:
        left = f"{1e3 * place['rms']:.1f} mrad while {place['phase']}"
        print(f"  before the last of them, stretches left {left}", file=sys.stderr)
    return names


def _models(made: Campaign, names: Sequence[str]) -> dict[str, Any]:
    """Name -> what gives a position for a recording; all fitted to the same stretches."""
    known = [each.recording for each in made.entries if each.role != "show"]
    base = _fitted(made, ())
    grown = _fitted(made, names) if names else base
    size = len(made.plant.free) + 1
    lag, arx = DelayedLag.fitted(known), ARX.fitted(known, size)
    return {
        "base refitted": base, "with what was found": grown,
        "delayed lag": lag.position, "ARX": arx.position,
    }  # fmt: skip


def _fitted(made: Campaign, names: Sequence[str]) -> Any:
    plant = made.plant.with_effects(*(made.effects[name] for name in names))
    segments = [Segment(each, each.role, plant.judged_part(each.recording))
                for each in made.entries if each.role != "show"]  # fmt: skip
    residual = WeightedResidual(plant, segments, {"position": 1e-2})
    found = fit(residual, plant)
    for _ in range(2):  # on from where the bounded number of evaluations ended
        found = fit(residual, plant, found.values)
    return lambda recording: plant.simulate(found.values, recording)["position"]


def _left(model: Any, recording: Recording) -> float:
    """RMS of position [rad]."""
    try:
        return float(np.sqrt(np.mean((model(recording) - recording["position"]) ** 2)))
    except ComputationFailed:
        return float("inf")


def _rows(joint: Joint, made: Campaign, models: Mapping[str, Any]) -> list[Row]:
    return [
        {"machine": f"SO-101 {joint.name}, {entry.condition}",
         **{name: 1e3 * _left(model, entry.recording) for name, model in models.items()}}
        for entry in made.of("show")
    ]  # fmt: skip


def _bounds(joint: Joint, made: Campaign, models: Mapping[str, Any]) -> list[Row]:
    """The RMS over all show motions against the base's, the floor's, the lag's and the ARX's."""
    shown = made.of("show")
    samples = [len(each.recording) for each in shown]
    base, found, *others = (
        float(np.sqrt(np.average([_left(m, e.recording) ** 2 for e in shown], weights=samples)))
        for m in models.values()
    )
    segments = [Segment(e, "show", made.plant.judged_part(e.recording)) for e in shown]
    floor = TIMES_FLOOR * noise_floors(made.plant, segments)[0]["position"]
    most = max((1.0 - LEAST_GAIN) * base, floor)
    name = f"SO-101 {joint.name}, show motions: RMS of position [mrad]"
    limits = {"base": most, **dict(zip(list(models)[2:], others, strict=True))}
    return [
        must_show(f"{name}, beside {each}", 1e3 * found, 1e3 * limit, found <= limit)
        for each, limit in limits.items()
    ]
