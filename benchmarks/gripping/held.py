"""One object: grasped by a simulated board with and without the policy, then pulled and shaken."""

import math
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.gripping.force import scores
from hannes import load_experiment
from hannes.bench.events import Event, Row
from hannes.bench.force_observer import ForceObserver
from hannes.bench.grip_loop import GripLoop, GripPlan
from hannes.bench.record import command_points
from hannes.bench.simulated_board import BEAT, SimulatedBoard, grasped
from hannes.bench.virtual_hand import VirtualHand
from hannes.core.recording.recording import Recording
from hannes.dataset.sampling import SampledGrasp, sample_grasp
from hannes.dataset.spec import Spec, load_spec
from hannes.recognition import model_file
from hannes.recognition.known_hand import hand_numbers
from hannes.recognition.model import Model

FULL, SPEED = 9.84, 9.84 / 0.637  # rad, rad/s: the paper's closure, then held
HOLD, PULL, SHAKE = 1.4, 0.5, 0.7  # s of each part
PULLED, SHAKEN, FREQUENCY = 2.0, 5e-3, 3.0  # N, m, Hz
WEAKEST = 5.0  # N: an object that full closure holds with less is hardly grasped


@cache
def spec(name: str = "forty") -> Spec:
    """Which objects and hands: the `forty`, or those of `development`."""
    return load_spec(Path(__file__).parent / f"{name}.toml")


@cache
def model(path: str) -> Model:
    """The trained model."""
    return model_file.read(path)


class Disturbed(VirtualHand):
    """A virtual hand whose object is pulled, and which is shaken, from HOLD on.

    Both act as gravity does, in the hand's own frame: on the object, and on the phalanges too.
    """

    def __init__(self, sampled: SampledGrasp) -> None:
        super().__init__(sampled.hand, sampled.experiment)
        chance = np.random.default_rng([sampled.seed, 1])
        self._pull, self._shake = 2.0 * math.pi * chance.random(2)
        self._weight = sampled.hand.parameters["gravity.x"]
        self._mass = sampled.hand.parameters["floating_object.mass"]
        self.shift: list[tuple[float, float]] = []
        self.now: dict[str, float] = {}

    def step(self, reference: float | None) -> dict[str, float]:
        """One tick, with what acts on the object then."""
        time = self._stepper.time
        along_x, along_y = self._acting(time)
        self._stepper.set_value("gravity_x", self._weight + along_x)
        self._stepper.set_value("gravity_y", along_y)
        self.now = values = super().step(reference)
        state = self._stepper.state()
        place = [float(state[f"floating_object.shift_{axis}"][0]) for axis in "xy"]
        self.shift.append((place[0], place[1]))
        return values

    def _acting(self, time: float) -> tuple[float, float]:
        """Acceleration [m/s2] in the hand's frame at `time` [s]."""
        if HOLD <= time < HOLD + PULL:
            size, angle = PULLED / self._mass, self._pull
        elif time >= HOLD + PULL:
            speed = 2.0 * math.pi * FREQUENCY
            size = SHAKEN * speed**2 * math.sin(speed * (time - HOLD - PULL))
            angle = self._shake
        else:
            return 0.0, 0.0
        return size * math.cos(angle), size * math.sin(angle)

    def moved(self, first: float) -> float:
        """How far the object went in the hand from HOLD, at most, after `first` [s]; in m."""
        places = np.array(self.shift)
        away = np.hypot(*(places - places[round(1e3 * HOLD) - 1]).T)
        return float(away[round(1e3 * first) :].max())


@dataclass(frozen=True)
class Run:
    """One grasp: true force [N], current [A], observer's and forest's estimates, (n, 3) each."""

    force: np.ndarray
    current: np.ndarray
    observed: np.ndarray
    forest: np.ndarray
    residual: float
    firm: bool
    rigid: float
    stiffness: float
    moved: float


def empty_hand(sampled: SampledGrasp, trained: Model) -> np.ndarray:
    """Numbers of the hand's empty closure, as the board sends them before the grasp."""
    (variant,) = load_experiment("empty-closure")
    command = variant.experiment
    seed = int(np.random.default_rng([sampled.seed, 2]).integers(2**31))
    alone = replace(sampled.experiment, object=None, seed=seed)
    board = SimulatedBoard(VirtualHand(sampled.hand, alone))
    speaker = board.speaker
    for packet in [speaker.ask(), *speaker.profile(command_points(command)), speaker.start()]:
        board.send(packet)
    names = [channel.name for channel in VirtualHand.channels]
    events: list[Event] = []
    for tick in range(round(1e3 * command.duration) + 1):
        events += board.send(speaker.alive(tick)) if tick % BEAT == 0 else []
        events += board.tick()
    rows = np.array([event.values for event in events if isinstance(event, Row)]).T
    channels = {"time": 1e-3 * np.arange(rows.shape[1]), **dict(zip(names, rows, strict=True))}
    units = {channel.name: channel.unit for channel in VirtualHand.channels}
    return hand_numbers(Recording(channels, {"time": "s", **units}), trained)


def grasp(
    sampled: SampledGrasp,
    trained: Model,
    policy: bool,
    observed: bool = True,
    hand: np.ndarray | None = None,
) -> Run:
    """Close, hold, pull and shake; all numbers as the board sends them.

    hand: numbers of its empty closure, None for one that is not known.
    """
    machine = Disturbed(sampled)
    loop = GripLoop(trained, GripPlan(policy), ForceObserver() if observed else None, hand)
    board = SimulatedBoard(machine)
    force, current, seen, forest = [], [], [], []
    latest, decision, residual, guess = (math.nan,) * 3, None, 0.0, (0.0, 0.0, 0.0)
    ticks = round(1e3 * (HOLD + PULL + SHAKE))
    for said in grasped(board, loop, lambda time: min(SPEED * time, FULL), ticks):
        for each in said:
            if each.force is not None:
                latest = each.force.value, each.force.low, each.force.high
                residual = max(residual, each.force.residual if len(force) < 1e3 * HOLD else 0.0)
            for decision in each.decisions:
                found = decision.force
                guess = (found.value, found.low, found.high) if found else guess
        force.append(machine.truth["force"])
        current.append(machine.now["current"])
        seen.append(latest)
        forest.append(guess)
    last = decision.stiffness if decision else None
    arrays = [np.array(each) for each in (force, current, seen, forest)]
    return Run(
        arrays[0], arrays[1], arrays[2], arrays[3], residual, loop.firm,
        decision.rigid if decision else 0.5, last.value if last else math.nan, machine.moved(HOLD),
    )  # fmt: skip


def drawn(number: int, name: str = "forty") -> SampledGrasp:
    """Object `number`, without a data set's own noise."""
    sampled = sample_grasp(spec(name), number)
    noise = {"current": sampled.values["noise.current"]}
    return replace(sampled, experiment=replace(sampled.experiment, noise=noise))


def measured(path: str, data: str, number: int, name: str = "forty") -> dict[str, Any]:
    """One line of the study: the object, with and without the policy."""
    sampled = drawn(number, name)
    trained = model(path)
    known = {
        "stiffness": sampled.values["object.stiffness"],
        "mass": sampled.values["floating_object.mass"],
        "friction": sampled.values["object.friction"],
        "radius": sampled.values["object.radius"],
    }
    bare = grasp(sampled, trained, policy=False)
    hold = round(1e3 * HOLD)
    if bare.force[:hold].max() < WEAKEST:
        return known | {"held": False}
    under = grasp(sampled, trained, policy=True, hand=empty_hand(sampled, trained))
    return known | {
        "held": True,
        "full": float(bare.force[:hold].max()),
        "squeezed": float(under.force[:hold].max()),
        "share": float(under.force[:hold].max() / bare.force[:hold].max()),
        "kept": float(under.force[hold - 1] / bare.force[hold - 1]),
        "firm": under.firm,
        "rigid": under.rigid,
        "recognised": under.stiffness,
        "moved": 1e3 * under.moved,
        "moved_without": 1e3 * bare.moved,
        "residual": max(bare.residual, under.residual),
        "force": {"policy": of_force(data, under, hold), "full": of_force(data, bare, hold)},
    }


def of_force(data: str, run: Run, hold: int) -> dict[str, dict[str, float]]:
    """Scores of all estimates of the force, until the object is pulled."""
    return scores(
        data, run.force[:hold], run.current[:hold], run.observed[:hold], run.forest[:hold]
    )
