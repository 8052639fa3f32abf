"""Runs of a hand whose single parts differ for themselves.

Fingers are made alike and are not alike: each joint's arm, spring, friction and stop is a little
off, and nobody has measured by how much. The values that are fitted hold for all five. An object
that an experiment gives is not quite as it is stated either, and no parameter of the hand says so.
What each of these does to a run is simulated here, one at a time; a fit takes it as uncertain.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from hannes.core.errors import ComputationFailed
from hannes.core.recording.recording import Recording
from hannes.simulation.batch.in_step import run_alike
from hannes.simulation.compiled_call import Plan, ended
from hannes.simulation.experiment.experiment import Experiment
from hannes.simulation.hand import variables
from hannes.simulation.hand.anatomy import JOINTS
from hannes.simulation.hand.hand import Hand
from hannes.simulation.hand.joint_shares import QUANTITIES
from hannes.simulation.trajectory import Outcome

STEP = 0.01  # relative, of the differences
OF_OBJECT = {"object.stiffness": 0.0, "object.damping": 0.0, "object.friction": 0.0,
             "object.x": 10e-3, "object.y": 10e-3}  # fmt: skip  # m, to which a place is relative
DRAWS = 16  # hands whose joints are all off at once
NEARER = (0.25, 0.05, -0.05)  # shares of a difference at whose whole no run succeeds
Channels = dict[str, np.ndarray]
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


@dataclass(frozen=True)
class Asked:
    """A run whose neighbours are simulated: hand and experiment, the recording whose times count.

    values: of the hand's parameters there [SI], by full name
    """

    hand: Hand
    experiment: Experiment
    recording: Recording
    values: Mapping[str, float]
    channels: tuple[str, ...]


def slopes(asked: Asked, steps: Mapping[str, float]) -> dict[str, dict[str, np.ndarray]]:
    """Name -> change of each channel at the recorded times, per unit, by each of `steps` and parts.

    Central differences over `steps` [SI] at `values`; of parts per relative deviation of 1. All of
    the continuous controller, all runs by the solver's steps of one. Where a run fails, from the
    other side or over less. Raises ComputationFailed where no run nearby succeeds.
    """
    runs, experiment, recording = _Runs.at(asked), asked.experiment, asked.recording
    plan, posed = runs.plan, runs.posed
    ways = _of_parts(plan, runs.base, experiment)
    for name, step in steps.items():
        here, ends = _ends(posed, experiment, name, step)
        vectors = [posed.with_values({name: at}).vector(experiment.shape, asked.hand.effects)
                   for at in ends]  # fmt: skip
        ways[name] = Way(here, dict(zip(ends, vectors, strict=True)))
    made = runs.of(ways)
    if lost := [name for name, each in made.items() if ways[name].ends and len(each) == 1]:
        made |= runs.of({name: ways[name].times(runs.base, *NEARER) for name in lost})
    since = recording.time - (recording.time[0] if "reference" in recording else 0.0)
    return {
        name: {n: np.interp(since, plan.times, each) for n, each in _slope(name, places).items()}
        for name, places in made.items()
    }


def apart(asked: Asked, share: float) -> dict[str, tuple[Channels, Channels]]:
    """Name of each joint's own deviation -> changes of each channel by it: up, and down.

    share: how far it is off, relative. With contacts one change is not the other's reverse. Where
    one fails it is taken as that. Raises ComputationFailed as `slopes` does.
    """
    runs = _Runs.at(asked)
    moves = _moves(runs, asked.experiment, share)
    found = dict(zip(moves, runs.changes(moves.values(), asked.recording), strict=True))
    for name, (up, down) in found.items():
        if not (up or down):
            raise ComputationFailed(_unknown(name))
        found[name] = (up or _reversed(down), down or _reversed(up))
    return found


def together(asked: Asked, share: float) -> list[tuple[Channels, Channels]]:
    """Changes of each channel in hands whose joints are all off at once; and as far the other way.

    share: standard deviation of what each joint is off, relative. The draws are the same for every
    run, in their order. {} for a side that fails. Raises ComputationFailed as `slopes` does.
    """
    runs = _Runs.at(asked)
    moves = np.array(list(_moves(runs, asked.experiment, share).values()))
    draws = np.random.default_rng(DRAWS).standard_normal((DRAWS, len(moves))) @ moves
    return runs.changes(draws, asked.recording)


def shares(values: Mapping[str, float], deviations: Mapping[str, float]) -> dict[str, float]:
    """Each joint's own values [SI] by full name, with it off by what its deviation says, relative.

    values: of the hand;  deviations: by the names of `parts`
    """
    found = {}
    for name, deviation in deviations.items():
        joint, _, quantity = name.partition(".")
        own = "{}.{}_{}".format(*joint.split("_"), quantity)
        low, high = QUANTITIES[quantity]
        found[own] = min(max(low, values[own] * (1.0 + deviation)), high)
    return found


def _moves(runs: "_Runs", experiment: Experiment, share: float) -> dict[str, np.ndarray]:
    """Name of each joint's own deviation -> change of the packed vector by it."""
    ways = _of_parts(runs.plan, runs.base, experiment)
    like = [name for name, each in parts(experiment).items() if each]
    ends = {name: next(iter(ways[name].ends.values())) for name in like}
    return {name: share / STEP * (end - runs.base) for name, end in ends.items()}


def _reversed(change: Channels) -> Channels:
    return {name: -values for name, values in change.items()}


@dataclass(frozen=True)
class Way:
    """Along one parameter or part: its value here, and packed vectors by its values elsewhere.

    No ends: it cannot differ.
    """

    here: float
    ends: Mapping[float, np.ndarray]

    def times(self, base: np.ndarray, *shares: float) -> "Way":
        """The same with ends at shares of the distance of those that there are."""
        return Way(
            self.here,
            {
                self.here + share * (at - self.here): base + share * (vector - base)
                for at, vector in self.ends.items()
                for share in shares
            },
        )


@dataclass(frozen=True)
class _Runs:
    """Runs of a posed hand from one packed vector and near it."""

    plan: Plan
    posed: Hand
    base: np.ndarray

    @classmethod
    def at(cls, asked: Asked) -> "_Runs":
        """Of what is asked for."""
        experiment, effects = asked.experiment, asked.hand.effects
        posed = asked.hand.with_values(asked.values).with_values(experiment.overrides())
        plan = Plan.of(posed.compiled(effects), experiment, TOLERANCE, asked.channels).make_ready()
        return cls(plan, posed, posed.vector(experiment.shape, effects))

    def changes(
        self, moves: Iterable[np.ndarray], recording: Recording
    ) -> list[tuple[Channels, Channels]]:
        """Changes of channels at the recorded times by each move and by its reverse; {} of one
        that fails."""
        both = np.array([side * move for move in moves for side in (1.0, -1.0)])
        here, *made = self.made(self.base + np.vstack([np.zeros_like(self.base), both]))
        since = recording.time - (recording.time[0] if "reference" in recording else 0.0)

        def change(there: Channels) -> Channels:
            return {n: np.interp(since, self.plan.times, there[n] - here[n]) for n in there}

        changes = [change(each) for each in made]
        return list(zip(changes[::2], changes[1::2], strict=True))

    def made(self, vectors: np.ndarray) -> list[Channels]:
        """Channels of each run, all by the steps of the first one; {} of one that fails.

        Raises ComputationFailed where the first one does."""
        ran = run_alike(self.plan, vectors, self.posed.rests(self.plan.compiled, vectors))
        done = [
            self.plan.named(kept) if ended(counts)[0] is Outcome.COMPLETED else {}
            for kept, counts in zip(ran.kept, ran.counts, strict=True)
        ]
        if not done[0]:
            raise ComputationFailed("the hand cannot be simulated here, so no derivative is known")
        return done

    def of(self, ways: Mapping[str, Way]) -> dict[str, dict[float, Channels]]:
        """Value along each way -> channels, where that can be simulated; here first."""
        vectors = np.array([self.base, *(v for way in ways.values() for v in way.ends.values())])
        done = self.made(vectors)
        found, rest = {}, iter(done[1:])
        for name, way in ways.items():
            ends = {at: next(rest) for at in way.ends} or {way.here + 1.0: done[0]}
            found[name] = {way.here: done[0], **{at: each for at, each in ends.items() if each}}
        return found


def _slope(name: str, places: Mapping[float, Channels]) -> Channels:
    """Change of each channel per unit, between the two places that are farthest from each other."""
    low, high = min(places), max(places)
    if low == high:
        raise ComputationFailed(_unknown(name))
    one, other = places[low], places[high]
    return {n: (other[n] - one[n]) / (high - low) for n in one}


def _unknown(name: str) -> str:
    return f"no hand with another {name} can be simulated near here, so what it does is not known"


def _ends(
    hand: Hand, experiment: Experiment, name: str, step: float
) -> tuple[float, tuple[float, ...]]:
    """A parameter's value, and those on both sides, inside its bounds.

    None where the experiment gives it, but the place of its own object moves with the hand's.
    """
    at, (low, high) = hand.parameters[name], hand.parameters.declared[name].bounds
    if name in experiment.overrides() and name not in ("object.x", "object.y"):
        return at, ()
    ends = max(low, at - step), min(high, at + step)
    return at, tuple(end for end in ends if end != at)


def _of_parts(plan: Plan, base: np.ndarray, experiment: Experiment) -> dict[str, Way]:
    """The way of each part, off by STEP, in the order of `parts`."""
    slots, own = plan.compiled.parameters, _own(experiment)
    places = [
        slots[f"joint_{quantity}"].start + joint
        for quantity in QUANTITIES
        for joint in range(len(JOINTS))
    ]
    places += [variables.PACKED.index(name) for name in own]
    scales = [base[place] for place in places[: len(places) - len(own)]]
    scales += [OF_OBJECT[name] or base[variables.PACKED.index(name)] for name in own]
    vectors = np.tile(base, (len(places), 1))
    for row, (place, scale) in enumerate(zip(places, scales, strict=True)):
        vectors[row, place] += STEP * scale
    return {
        name: Way(0.0, {STEP: vector})
        for name, vector in zip(parts(experiment), vectors, strict=True)
    }
