"""Runs of a hand whose single parts differ for themselves, which its parameters leave out.

Fingers are made alike and are not alike: each joint's arm, spring, friction and stop is a little
off. The hand's parameters hold for all five fingers. An object that an experiment gives is not
quite as it is stated either, and no parameter of the hand says so. What each of these does to a run
is simulated here, one at a time; a fit takes it as uncertain.
"""

from collections.abc import Mapping

import numpy as np

from hannes.core.recording.recording import Recording
from hannes.simulation.compiled_call import Plan, ended
from hannes.simulation.experiment.experiment import Experiment
from hannes.simulation.hand import variables
from hannes.simulation.hand.anatomy import JOINTS
from hannes.simulation.hand.hand import Hand
from hannes.simulation.trajectory import Outcome

STEP = 0.01  # relative, of the differences
QUANTITIES = (
    "moment_arm",
    "spring_stiffness",
    "spring_preload",
    "breakaway_friction",
    "coulomb_friction",
    "viscous_friction",
    "stop_stiffness",
)
OF_OBJECT = {"object.stiffness": 0.0, "object.damping": 0.0, "object.friction": 0.0,
             "object.x": 10e-3, "object.y": 10e-3}  # fmt: skip  # m, to which a place is relative
TOLERANCE = 1e-4  # all runs take the steps of one: its error cancels in the differences


def parts(experiment: Experiment) -> dict[str, bool]:
    """Name of each part's own deviation -> whether it is one of several like parts."""
    joints = [f"{joint}.{quantity}" for quantity in QUANTITIES for joint in JOINTS]
    return {**dict.fromkeys(joints, True), **dict.fromkeys(_own(experiment).values(), False)}


def _own(experiment: Experiment) -> dict[str, str]:
    """Parameter of the experiment's own object -> the name of its deviation."""
    if experiment.object is None:
        return {}
    given = experiment.overrides()
    own = {name: given[name] for name in OF_OBJECT if name in given}
    text = ", ".join(f"{n.partition('.')[2]} {x:g}" for n, x in own.items() if not OF_OBJECT[n])
    return {name: f"{name} ({experiment.object.shape}, {text})" for name in own}


def slopes(
    hand: Hand,
    experiment: Experiment,
    recording: Recording,
    values: Mapping[str, float],
    steps: Mapping[str, float],
    channels: tuple[str, ...],
) -> dict[str, dict[str, np.ndarray]]:
    """Name -> change of each channel at the recorded times, per unit, by each of `steps` and parts.

    Central differences over `steps` [SI] at `values`; of parts per relative deviation of 1. All of
    the continuous controller, all runs by the solver's steps of one. Zero where a run fails.
    """
    posed = hand.with_values(values).with_values(experiment.overrides())
    compiled = posed.compiled(hand.effects)
    plan = Plan.of(compiled, experiment, TOLERANCE, channels).make_ready()
    ends = {name: _ends(posed, experiment, name, step) for name, step in steps.items()}
    of_parts = _moved(plan, posed.vector(experiment.shape, hand.effects), experiment)
    rows = [
        posed.with_values({name: at}).vector(experiment.shape, hand.effects)
        for name, pair in ends.items()
        for at in pair
    ]
    vectors = np.array([*of_parts, *rows])
    ran = plan.run(vectors, posed.rests(compiled, vectors), alike=True)
    done = [ended(counts)[0] is Outcome.COMPLETED for counts in ran.counts]
    since = recording.time - (recording.time[0] if "reference" in recording else 0.0)

    def change(low: int, high: int, apart: float) -> dict[str, np.ndarray]:
        if not (done[0] and done[low] and done[high] and apart):
            return {name: np.zeros(since.size) for name in channels}
        one, two = plan.named(ran.kept[low]), plan.named(ran.kept[high])
        return {n: np.interp(since, plan.times, (two[n] - one[n]) / apart) for n in channels}

    found = {name: change(0, row, STEP) for row, name in enumerate(parts(experiment), 1)}
    for place, (name, pair) in enumerate(ends.items()):
        row = len(of_parts) + 2 * place
        found[name] = change(row, row + 1, pair[1] - pair[0])
    return found


def _ends(hand: Hand, experiment: Experiment, name: str, step: float) -> tuple[float, float]:
    """Values of a parameter on both sides, inside its bounds; equal where the experiment gives it.

    The place of an experiment's own object moves with the hand's.
    """
    at, (low, high) = hand.parameters[name], hand.parameters.declared[name].bounds
    if name in experiment.overrides() and name not in ("object.x", "object.y"):
        return at, at
    return max(low, at - step), min(high, at + step)


def _moved(plan: Plan, base: np.ndarray, experiment: Experiment) -> np.ndarray:
    """Packed vectors: as given, then each part off by STEP, in the order of `parts`."""
    slots, own = plan.compiled.parameters, _own(experiment)
    places = [
        slots[f"joint_{quantity}"].start + joint
        for quantity in QUANTITIES
        for joint in range(len(JOINTS))
    ]
    places += [variables.PACKED.index(name) for name in own]
    scales = [base[place] for place in places[: len(places) - len(own)]]
    scales += [OF_OBJECT[name] or base[variables.PACKED.index(name)] for name in own]
    vectors = np.tile(base, (1 + len(places), 1))
    for row, (place, scale) in enumerate(zip(places, scales, strict=True), 1):
        vectors[row, place] += STEP * scale
    return vectors
