"""The hand as a plant: driven by a recorded reference, with the object of its experiment."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from hannes.core.by_value import ByValue
from hannes.core.effect import Effect
from hannes.core.errors import BadInput
from hannes.core.parameter import ParameterSet
from hannes.core.recording.recording import Recording
from hannes.plants.hand import axes, batch_runs, candidate_runs, joint_deviations
from hannes.plants.hand.channel_limits import EXPECTED
from hannes.plants.hand.moved_values import moved_values
from hannes.plants.hand.noise_bandwidth import noise_bandwidth
from hannes.plants.hand.recorded_experiment import (
    effects_on_object,
    experiment_of,
    motion,
    with_sampled_controller,
)
from hannes.simulation.experiment.experiment import Experiment
from hannes.simulation.hand import variables as channels
from hannes.simulation.hand.hand import Hand
from hannes.simulation.hand.model import EQUATIONS
from hannes.simulation.simulate import simulate

# Relative standard deviation of the nominal values of a real hand.
SPREAD = 0.03
FREE = (
    "motor.torque_constant", "motor.resistance", "motor.dry_friction", "gear.pulley_radius",
    "mcp.moment_arm", "pip.moment_arm", "mcp.spring_stiffness", "pip.spring_stiffness",
    "mcp.spring_preload", "pip.spring_preload", "mcp.coulomb_friction", "mcp.breakaway_friction",
    "mcp.viscous_friction", "pip.breakaway_friction", "pip.viscous_friction",
    "cart.viscous_friction",
)  # fmt: skip
# Run-to-run standard deviation: a choice, nobody published one.
RUN_TO_RUN = dict.fromkeys(  # relative
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
MOVED = dict.fromkeys(("object.x", "object.y"), 0.2e-3)  # m, run-to-run, of an object's place
# Known exactly: controller, gear, poses and regularisations. All else is uncertain.
CERTAIN = (
    *("position_pid.", "current_pid.", "controller.", "encoder.", "gravity.", "supply."),
    *("gear.ratio", "motor.friction_speed", "object.slip_speed", "object.radius"),
    *("object.half_x", "object.half_y", "object.z", "object.turn", "object.tilt_"),
)
CERTAIN_ENDINGS = ("onset", ".mount_x", ".mount_y", ".mount_z", ".facing", ".first_length")
PLACED = dict.fromkeys(("object.x", "object.y"), 10e-3)  # m, scale of an object's place
TOLERANCE = 1e-5
Values = Mapping[str, float]
Columns = dict[str, np.ndarray]  # by full name


class HandPlant(ByValue):
    """Plant: a Hannes hand with effects in its model; see plants/protocol.py for the protocol."""

    name = "hand"
    longest_counted = 1.5  # s: slower commands take few more steps of the solver
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
    judged: tuple[str, ...] = ("current", "position", "duty", "supply", "force", "sensor")
    loggable: Mapping[str, str] = {"duty": "1"}
    block = 0.2
    expected = EXPECTED
    compiled_from = EQUATIONS
    start_time = 0.01  # s, standard deviation of a run's start against its clock

    def __init__(self, hand: Hand | None = None) -> None:
        self.hand = hand or Hand()

    def __hash__(self) -> int:
        return hash((type(self), self.hand))

    def __repr__(self) -> str:
        return f"HandPlant({self.hand!r})"

    @property
    def parameters(self) -> ParameterSet:
        """Parameters of base and effects, at their nominal values."""
        return self.hand.parameters

    @property
    def effects(self) -> tuple[Effect, ...]:
        """Effects in the model."""
        return self.hand.effects

    @property
    def catalogue(self) -> Mapping[str, Effect]:
        """Faults of one finger, settings other than stated, what changes from run to run."""
        return moved_values(self.parameters)

    @property
    def free(self) -> Mapping[str, float]:
        """Standard deviation of what a refit fits [SI]: `SPREAD` times each nominal value."""
        return {name: SPREAD * abs(self.parameters[name]) for name in FREE}

    @property
    def run_to_run(self) -> Mapping[str, float]:
        """Run-to-run standard deviation by parameter [SI]."""
        return {n: share * abs(self.parameters[n]) for n, share in RUN_TO_RUN.items()} | MOVED

    @property
    def uncertain(self) -> Mapping[str, float]:
        """Uncertain parameters, each with the size [SI] that its relative error refers to."""
        own = (each.name for each in channels.PARAMETERS if not each.shared)
        names = [
            name
            for name in own
            if not name.startswith(CERTAIN) and not name.endswith(CERTAIN_ENDINGS)
        ]
        return {name: abs(self.parameters[name]) for name in names} | PLACED

    def parts(self, recording: Recording) -> dict[str, bool]:
        """What single parts are off for themselves in a run, see joint_deviations.py."""
        return joint_deviations.parts(experiment_of(recording))

    def slopes(
        self, parameters: Values, steps: Values, recording: Recording, channels: Sequence[str]
    ) -> dict[str, Columns]:
        """Change of channels by parameters and by parts, see joint_deviations.py."""
        return joint_deviations.slopes(self._near(parameters, recording, channels), steps)

    def apart(
        self, parameters: Values, share: float, recording: Recording, channels: Sequence[str]
    ) -> dict[str, tuple[joint_deviations.Channels, joint_deviations.Channels]]:
        """Changes of channels by each joint off by a share for itself, see joint_deviations.py."""
        return joint_deviations.apart(self._near(parameters, recording, channels), share)

    def together(
        self, parameters: Values, share: float, recording: Recording, channels: Sequence[str]
    ) -> list[tuple[joint_deviations.Channels, joint_deviations.Channels]]:
        """Changes of channels by all joints off at once, see joint_deviations.py."""
        return joint_deviations.together(self._near(parameters, recording, channels), share)

    def with_parts(self, deviations: Values) -> "HandPlant":
        """The plant with its joints so far off for themselves, relative."""
        return self.with_values(joint_deviations.shares(self.parameters, deviations))

    def _near(self, at: Values, run: Recording, names: Sequence[str]) -> joint_deviations.Asked:
        return joint_deviations.Asked(self.hand, self._smooth(at, run), run, at, tuple(names))

    def with_effects(self, *effects: Effect) -> "HandPlant":
        """Return a plant whose hand has `effects` too."""
        return HandPlant(self.hand.with_effects(*effects))

    def with_values(self, values: Mapping[str, float]) -> "HandPlant":
        """Return a plant with other nominal values; BadInput on unknown name or bounds."""
        return HandPlant(self.hand.with_values(values))

    def accepts(self, effect: Effect) -> str:
        """Return why the hand cannot carry `effect`, or an empty string."""
        return EQUATIONS.accepts(effect)

    def check(self, recording: Recording) -> None:
        """Raise BadInput unless the recording holds a command that this hand can follow."""
        experiment_of(recording)
        own = {each.name for each in self.effects}
        for name in effects_on_object(recording.experiment):
            if name not in own:
                raise BadInput(
                    f'the experiment has effects = ["{name}"], by which its object moves, and the '
                    f'hand has not: base = a hand.toml with effects = ["{name}"] and its parameters'
                )

    def simulate(self, parameters: Mapping[str, float], recording: Recording) -> Columns:
        """Run the recording's experiment under its reference; channels at the recorded times.

        The controller is the experiment's, the continuous one where the recording has none. Where
        an experiment places its own object, x and y of `parameters` shift it by their difference
        from the nominal ones. Raises ComputationFailed where the solver fails.
        """
        asked = self._with_moved_object(experiment_of(recording), parameters)
        return self._run(parameters, recording, asked)

    def smooth(self, parameters: Values, recording: Recording) -> Columns:
        """As `simulate`, but always with the continuous controller: fast and differentiable."""
        return self._run(parameters, recording, self._smooth(parameters, recording))

    def _smooth(self, parameters: Values, recording: Recording) -> Experiment:
        asked = replace(experiment_of(recording), controller="continuous")
        return self._with_moved_object(asked, parameters)

    def _with_moved_object(
        self, experiment: Experiment, parameters: Mapping[str, float]
    ) -> Experiment:
        """The experiment, its own object shifted as `parameters` shift the hand's."""
        own = experiment.object.values if experiment.object else {}
        moved = {
            name: own[name] + parameters[name] - self.parameters[name]
            for name in MOVED
            if name in own and name in parameters
        }
        if not moved or experiment.object is None:
            return experiment
        return replace(experiment, object=replace(experiment.object, values={**own, **moved}))

    def _run(self, parameters: Values, recording: Recording, experiment: Experiment) -> Columns:
        hand = self.hand.with_values(parameters)
        run = simulate(hand, experiment, rtol=TOLERANCE, effects=hand.effects).require()
        judged = (*self.judged, "reference")
        if "reference" not in recording:  # then time counts from the experiment's start
            return {name: np.interp(recording.time, run.time, run[name]) for name in judged}
        since = recording.time - recording.time[0]
        return {name: np.interp(since, run.time, run[name]) for name in judged}

    def many(
        self,
        columns: Mapping[str, np.ndarray],
        recording: Recording,
        channels: Sequence[str],
        exact: bool,
    ) -> list[Columns | None]:
        """Many runs at once, see batch_runs.py; None for one that fails."""
        return batch_runs.many(
            self.hand, experiment_of(recording), recording, columns, channels, exact
        )

    def alike(
        self, columns: Mapping[str, np.ndarray], recording: Recording, channels: Sequence[str]
    ) -> list[Columns | None]:
        """Runs near the first one, for their differences, see batch_runs.py."""
        return batch_runs.alike(self.hand, experiment_of(recording), recording, columns, channels)

    def noisy(self, recording: Recording, count: int, bandwidth: float | None = None) -> Columns:
        """Columns for `many` by which the controller reads noisy currents, see batch_runs.py."""
        return batch_runs.noisy(self.hand, experiment_of(recording), recording, count, bandwidth)

    def noise_bandwidth(self, repeats: Sequence[Sequence[Recording]]) -> float | None:
        """Bandwidth [Hz] of the current's noise in repeats, 0 where white, None if none show it."""
        return noise_bandwidth(self.hand, repeats)

    firmware = batch_runs.FIRMWARE
    tick = "controller.period"
    quantities = staticmethod(axes.quantities)

    sampled = staticmethod(with_sampled_controller)
    unrounded = staticmethod(batch_runs.unrounded)

    def counted(self, recording: Recording) -> bool:
        """Whether its position stands in whole counts of this hand's encoder."""
        return batch_runs.counted(self.hand, recording)

    def nominal(self, recording: Recording) -> dict[str, float]:
        """Nominal value of every parameter for a recording's run [SI]."""
        return batch_runs.nominal(self.hand, experiment_of(recording))

    def own(self, recording: Recording) -> tuple[str, tuple[str, ...]]:
        """The object of a recording's run, and the parameters of that object alone."""
        return batch_runs.own(experiment_of(recording))

    def proposals(self, recorded: Mapping[str, Recording]) -> dict[str, Recording]:
        """Candidate experiments, as recordings, beside those of each condition."""
        things = {name: self.own(recording)[0] for name, recording in recorded.items()}
        return candidate_runs.proposals(recorded, things)

    def same_run(self, recording: Recording) -> bytes:
        """Equal where reference, times and experiment are equal."""
        arrays = (recording[n].tobytes() for n in ("time", "reference") if n in recording)
        return b"".join(arrays) + recording.experiment.encode()

    def judged_part(self, recording: Recording) -> np.ndarray:
        """Every sample is compared."""
        return np.ones(len(recording), bool)

    def phases(self, recording: Recording) -> Columns:
        """Start (first 0.1 s of motion), closing, holding, opening, by the reference."""
        speed = np.gradient(motion(recording), recording.time)
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
