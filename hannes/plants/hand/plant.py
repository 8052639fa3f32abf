"""The hand as a plant: driven by a recorded reference, with the object of its experiment."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import lru_cache

import numpy as np

from hannes.core.effect import Effect
from hannes.core.errors import BadInput
from hannes.core.io.toml_table import Table
from hannes.core.parameter import ParameterSet
from hannes.core.recording.recording import Recording
from hannes.plants.hand import batch_runs, candidate_runs
from hannes.plants.hand.channel_limits import EXPECTED
from hannes.simulation.catalogue import laws_of_objects
from hannes.simulation.experiment.experiment import Experiment, Reference
from hannes.simulation.hand import variables as channels
from hannes.simulation.hand.hand import EQUATIONS, Hand
from hannes.simulation.simulate import simulate

# One standard deviation of what the given values of a real hand may be off, relative.
SPREAD = 0.03
FREE = (
    "motor.torque_constant",
    "motor.resistance",
    "motor.dry_friction",
    "gear.pulley_radius",
    "mcp.moment_arm",
    "pip.moment_arm",
    "mcp.spring_stiffness",
    "pip.spring_stiffness",
    "mcp.spring_preload",
    "pip.spring_preload",
    "mcp.coulomb_friction",
    "mcp.breakaway_friction",
    "mcp.viscous_friction",
    "pip.breakaway_friction",
    "pip.viscous_friction",
    "cart.viscous_friction",
)
# What differs from run to run, one standard deviation: a choice, nobody published one.
RESTLESS = dict.fromkeys(  # relative
    (
        *(f"{part}.{kind}_friction" for part in ("mcp", "pip", "cart")
          for kind in ("breakaway", "coulomb", "viscous")),
        *("motor.dry_friction", "motor.viscous_friction", "object.friction"),
    ),
    0.01,
) | dict.fromkeys(
    (
        *("motor.torque_constant", "motor.resistance", "supply.voltage"),
        *("mcp.spring_stiffness", "mcp.spring_preload"),
        *("pip.spring_stiffness", "pip.spring_preload"),
    ),
    0.005,
)  # fmt: skip
MOVED = dict.fromkeys(("object.x", "object.y"), 0.2e-3)  # m, by which an object is put elsewhere
# What nobody knows of a hand is all but its firmware, gear, poses and regularisations.
CERTAIN = (
    *("position_pid.", "current_pid.", "controller.", "encoder.", "gravity.", "supply."),
    *("gear.ratio", "motor.friction_speed", "object.slip_speed", "object.radius"),
    *("object.half_x", "object.half_y", "object.z", "object.turn", "object.tilt_"),
)
CERTAIN_ENDINGS = ("onset", ".mount_x", ".mount_y", ".mount_z", ".facing", ".first_length")
PLACED = dict.fromkeys(("object.x", "object.y"), 10e-3)  # m, of which a share may be missed
MOST_KNOTS = 40  # a reference with more corners is integrated without restarts
TOLERANCE = 1e-5


class HandPlant:
    """Plant: a Hannes hand with effects in its model; see plants/protocol.py for the protocol."""

    name = "hand"
    channels: Mapping[str, str] = {
        "time": "s",
        "reference": "rad",
        "position": "rad",
        "current": "A",
        "duty": "1",
        "supply": "V",
        "force": "N",
        "sensor": "N",
    }
    required: tuple[str, ...] = ()
    judged = ("current", "position", "duty", "supply", "force", "sensor")
    loggable: Mapping[str, str] = {"duty": "1"}
    block = 0.2
    expected = EXPECTED
    start_time = 0.01  # s, standard deviation of when a run starts after its clock says so

    def __init__(self, hand: Hand | None = None) -> None:
        self.hand = hand or Hand()

    @property
    def parameters(self) -> ParameterSet:
        """Base and effects, at the given values."""
        return self.hand.parameters

    @property
    def effects(self) -> tuple[Effect, ...]:
        """Effects in the model."""
        return self.hand.effects

    @property
    def free(self) -> Mapping[str, float]:
        """What a refit moves: 3 % of the given value each."""
        return {name: SPREAD * abs(self.parameters[name]) for name in FREE}

    @property
    def restless(self) -> Mapping[str, float]:
        """What differs from run to run, one standard deviation."""
        return {n: share * abs(self.parameters[n]) for n, share in RESTLESS.items()} | MOVED

    @property
    def uncertain(self) -> Mapping[str, float]:
        """What is never known for sure, and the size [SI] of which a share may be off."""
        own = channels.PARAMETERS
        names = [
            each.name
            for each in own
            if not each.name.startswith(CERTAIN) and not each.name.endswith(CERTAIN_ENDINGS)
        ]
        return {name: abs(self.parameters[name]) for name in names} | PLACED

    def with_effects(self, *effects: Effect) -> "HandPlant":
        """Return a plant whose hand has `effects` too."""
        return HandPlant(self.hand.with_effects(*effects))

    def with_values(self, values: Mapping[str, float]) -> "HandPlant":
        """Return a plant with other given values; BadInput on unknown name or bounds."""
        return HandPlant(self.hand.with_values(values))

    def accepts(self, effect: Effect) -> str:
        """Return why the hand cannot carry `effect`, or an empty string."""
        return EQUATIONS.accepts(effect)

    def check(self, recording: Recording) -> None:
        """Raise BadInput unless the recording tells what was asked of a hand such as this."""
        posed(recording)
        own = {each.name for each in self.effects}
        for name in _moving(recording.experiment) if recording.experiment else ():
            if name not in own:
                raise BadInput(
                    f'the experiment has effects = ["{name}"], by which its object moves, and the '
                    f'hand has not: base = a hand.toml with effects = ["{name}"] and its parameters'
                )

    def simulate(
        self, parameters: Mapping[str, float], recording: Recording
    ) -> dict[str, np.ndarray]:
        """Run the recording's experiment under its reference; channels at the recorded times.

        The controller is the experiment's, the continuous one where the recording has none. An
        object's x and y are counted from the given ones where an experiment has a place of its own.
        Raises ComputationFailed where the solver gives up.
        """
        return self._run(parameters, recording, self._put(posed(recording), parameters))

    def smooth(
        self, parameters: Mapping[str, float], recording: Recording
    ) -> dict[str, np.ndarray]:
        """As `simulate`, but always with the continuous controller: quick, and it has slopes."""
        asked = replace(posed(recording), controller="continuous")
        return self._run(parameters, recording, self._put(asked, parameters))

    def _put(self, experiment: Experiment, parameters: Mapping[str, float]) -> Experiment:
        """The experiment, its own object put as far elsewhere as `parameters` put the hand's."""
        own = experiment.object.values if experiment.object else {}
        moved = {
            name: own[name] + parameters[name] - self.parameters[name]
            for name in MOVED
            if name in own and name in parameters
        }
        if not moved or experiment.object is None:
            return experiment
        return replace(experiment, object=replace(experiment.object, values={**own, **moved}))

    def _run(
        self, parameters: Mapping[str, float], recording: Recording, experiment: Experiment
    ) -> dict[str, np.ndarray]:
        hand = self.hand.with_values(parameters)
        run = simulate(hand, experiment, rtol=TOLERANCE, effects=hand.effects).require()
        judged = (*self.judged, "reference")
        if "reference" not in recording:  # then the experiment's own clock holds
            return {name: np.interp(recording.time, run.time, run[name]) for name in judged}
        since = recording.time - recording.time[0]
        return {name: np.interp(since, run.time, run[name]) for name in judged}

    def many(
        self,
        columns: Mapping[str, np.ndarray],
        recording: Recording,
        channels: Sequence[str],
        exact: bool,
    ) -> list[dict[str, np.ndarray] | None]:
        """Many runs at once, see batch_runs.py; None for one that breaks down."""
        return batch_runs.many(self.hand, posed(recording), recording, columns, channels, exact)

    def alike(
        self, columns: Mapping[str, np.ndarray], recording: Recording, channels: Sequence[str]
    ) -> list[dict[str, np.ndarray] | None]:
        """Runs near the first one, for their differences, see batch_runs.py."""
        return batch_runs.alike(self.hand, posed(recording), recording, columns, channels)

    def noisy(self, recording: Recording, count: int) -> dict[str, np.ndarray]:
        """Columns for `many` that let the firmware read noisy currents, see batch_runs.py."""
        return batch_runs.noisy(self.hand, posed(recording), recording, count)

    firmware = batch_runs.FIRMWARE

    def unrounded(self, count: int) -> dict[str, np.ndarray]:
        """Columns for `many` that let the firmware round nothing, see batch_runs.py."""
        return batch_runs.unrounded(count)

    def nominal(self, recording: Recording) -> dict[str, float]:
        """What every parameter is given for a recording's run."""
        return batch_runs.nominal(self.hand, posed(recording))

    def own(self, recording: Recording) -> tuple[str, tuple[str, ...]]:
        """The object of a recording's run, and the parameters that are its own."""
        return batch_runs.own(posed(recording))

    def proposals(self, recorded: Mapping[str, Recording]) -> dict[str, Recording]:
        """Runs that may be worth recording beside those of each condition that there are."""
        things = {name: self.own(recording)[0] for name, recording in recorded.items()}
        return candidate_runs.proposals(recorded, things)

    def same_run(self, recording: Recording) -> bytes:
        """Equal where reference, times and experiment are."""
        names = ("time", "reference")
        arrays = b"".join(recording[name].tobytes() for name in names if name in recording)
        return arrays + recording.experiment.encode()

    def judged_part(self, recording: Recording) -> np.ndarray:
        """Every sample counts."""
        return np.ones(len(recording), bool)

    def phases(self, recording: Recording) -> dict[str, np.ndarray]:
        """Start (first 0.1 s of motion), closing, holding, opening, by the reference."""
        speed = np.gradient(_motion(recording), recording.time)
        slow = 0.02 * max(np.abs(speed).max(), 1e-9)
        moving = np.flatnonzero(np.abs(speed) > slow)
        begun = recording.time[moving[0]] if moving.size else recording.time[0]
        start = (recording.time <= begun + 0.1) & (speed > slow)
        return {
            "start": start,
            "closing": (speed > slow) & ~start,
            "holding": np.abs(speed) <= slow,
            "opening": speed < -slow,
        }


def posed(recording: Recording) -> Experiment:
    """The experiment of a recording: object, values, controller, and the recorded reference.

    Raises BadInput where neither a reference nor an experiment tells what was asked of the hand.
    """
    planned = _planned(recording)
    if "reference" not in recording:
        if planned is None:
            raise BadInput(
                "the recording has neither a channel reference_rad nor an experiment: "
                "nothing tells what was asked of the hand"
            )
        return replace(planned, noise={})
    since = recording.time - recording.time[0]
    duration = float(since[-1])
    sampling = max(1, round(duration / float(np.median(np.diff(since))))) / duration
    reference = recorded_reference(since, recording["reference"])
    if planned is None:
        return Experiment("recorded", duration, reference, sampling=sampling)
    return replace(planned, duration=duration, reference=reference, sampling=sampling, noise={})


def _planned(recording: Recording) -> Experiment | None:
    if not recording.experiment:
        return None
    return _parsed(recording.experiment)


@lru_cache(maxsize=64)  # a fit poses the same few experiments hundreds of times
def _parsed(text: str) -> Experiment:
    from hannes.simulation.experiment.reader import parse_experiment

    return parse_experiment(text)


def _motion(recording: Recording) -> np.ndarray:
    """What tells when the hand closes: what was asked, else what came [rad]."""
    for name in ("reference", "position"):
        if name in recording:
            return recording[name]
    return np.interp(recording.time, *posed(recording).reference.knots)


def _moving(text: str) -> list[str]:
    """Laws of an experiment by which its object moves."""
    from hannes.simulation.experiment.reader import KEYS

    named = Table.parse(text, "experiment", KEYS).texts("effects")
    return [name for name in named if name in laws_of_objects()]


def recorded_reference(times: np.ndarray, values: np.ndarray) -> Reference:
    """Corners of a sampled reference where it is straight lines, else every sample."""
    slope = np.diff(values) / np.diff(times)
    bend = np.abs(np.diff(slope)) > 1e-4 * max(np.abs(slope).max(), 1e-12)
    corners = np.concatenate(([0], 1 + np.flatnonzero(bend), [times.size - 1]))
    if corners.size > MOST_KNOTS:
        return Reference(np.array([times, values]), kinked=False)
    return Reference(np.array([times[corners], values[corners]]))
