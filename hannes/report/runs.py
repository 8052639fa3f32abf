"""The simulations behind the page, by the names of the shipped experiments."""

import sys
from collections.abc import Callable
from dataclasses import dataclass, field, replace

from hannes import hand as hand_module
from hannes.experiment import Experiment, Reference, Target
from hannes.hand import Hand
from hannes.metrics import GraspMetrics, grasp_metrics
from hannes.report import virtual
from hannes.simulate import simulate
from hannes.trajectory import Trajectory

# The paper's void current comes from other hands than its dynamometer grasp.
VOID_UNIT: dict[str, float] = getattr(hand_module, "VOID_UNIT", {"motor.dry_friction": 3.6e-3})

STIFFNESSES = (300.0, 800.0, 1500.0, 3000.0, 5000.0, 8344.0, 15000.0, 30000.0)
QUICK_STIFFNESSES = (800.0, 3000.0, 8344.0)


@dataclass
class Runs:
    """Every trajectory the page shows."""

    hand: Hand
    rigid: Trajectory
    soft: Trajectory
    closure: Trajectory
    unit: Trajectory
    hands: list[Trajectory]
    sampled: Trajectory
    sweep: dict[float, Trajectory] = field(default_factory=dict)


def measured(run: Trajectory) -> GraspMetrics:
    """Table II's figures of one grasp."""
    return grasp_metrics(run.time, run["current"], run["force"], run["position"])


def run_all(*, quick: bool = False, progress: bool = True) -> Runs:
    """Run everything; `quick` leaves out part of the sweep. ComputationFailed where one fails."""
    hand, unit = Hand(), Hand().with_values(VOID_UNIT)
    grasp, free = _dynamometer(), _closure()
    sweep = QUICK_STIFFNESSES if quick else STIFFNESSES
    with _Bar(5 + virtual.COUNT + len(sweep), progress) as run:
        return Runs(
            hand,
            run(hand, grasp),
            run(hand, _ball()),
            run(hand, free),
            run(unit, free),
            [run(each, free) for each in virtual.hands(unit)],
            run(hand, replace(grasp, title="Dynamometer, sampled", controller="sampled")),
            {k: run(hand, _stiffened(grasp, k)) for k in sweep},
        )


class _Bar:
    """Runs one experiment after another and counts them on standard error."""

    def __init__(self, total: int, shown: bool) -> None:
        from tqdm import tqdm

        self.bar = tqdm(total=total, disable=not shown, file=sys.stderr, unit="run")

    def __enter__(self) -> Callable[[Hand, Experiment], Trajectory]:
        return self._run

    def __exit__(self, *_: object) -> None:
        self.bar.close()

    def _run(self, hand: Hand, experiment: Experiment) -> Trajectory:
        self.bar.set_description(experiment.title)
        done = simulate(hand, experiment).require()
        self.bar.update()
        return done


def _stiffened(experiment: Experiment, stiffness: float) -> Experiment:
    assert experiment.object is not None
    values = {**experiment.object.values, "object.stiffness": stiffness}
    target = replace(experiment.object, values=values)
    return replace(experiment, title=f"{stiffness:g} N/m", object=target)


def _dynamometer() -> Experiment:
    reference = Reference([[0.0, 0.637, 1.022], [0.0, 9.84, 0.0]])
    return Experiment("Dynamometer", 1.15, reference, Target("cylinder", {}, sensor=True))


def _ball() -> Experiment:
    values = {"object.stiffness": 800.0, "object.damping": 20.0}
    values |= {"object.radius": 0.034, "object.x": 0.0}
    return replace(_dynamometer(), title="Soft ball", object=Target("sphere", values))


def _closure() -> Experiment:
    reference = Reference([[0.0, 21.0 / 15.4], [0.0, 21.0]])
    return Experiment("Free closure", 1.6, reference)
