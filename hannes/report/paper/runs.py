"""The simulations behind the page, by the names of the shipped experiments."""

import sys
from collections.abc import Callable
from dataclasses import dataclass, field

from hannes.simulation.experiment.load import load_experiment
from hannes.simulation.experiment.variants import Variant
from hannes.simulation.grasp_metrics import GraspMetrics, grasp_metrics
from hannes.simulation.hand.hand import Hand
from hannes.simulation.simulate import simulate
from hannes.simulation.trajectory import Trajectory


@dataclass
class Runs:
    """Every trajectory the page shows."""

    hand: Hand
    unit_hand: Hand
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


def run_all(*, quick: bool = False, progress: bool | None = None) -> Runs:
    """Run everything; `quick` leaves out part of the sweep. ComputationFailed where one fails."""
    (rigid,), (soft,) = load_experiment("dynamometer"), load_experiment("soft-ball")
    (closure,), (unit,) = load_experiment("full-closure"), load_experiment("void-unit")
    hands, (_, sampled) = load_experiment("virtual-hands"), load_experiment("controllers")
    sweep = load_experiment("stiffness-sweep")[:: 3 if quick else 1]
    with _Bar(5 + len(hands) + len(sweep), progress) as run:
        return Runs(
            rigid.hand,
            unit.hand,
            run(rigid),
            run(soft),
            run(closure),
            run(unit),
            [run(each) for each in hands],
            run(sampled),
            {stiffness(each): run(each) for each in sweep},
        )


def stiffness(variant: Variant) -> float:
    """Contact stiffness of a variant's object [N/m]."""
    target = variant.experiment.object
    return target.values["object.stiffness"] if target else 0.0


class _Bar:
    """Runs one experiment after another and counts them on standard error."""

    def __init__(self, total: int, shown: bool | None) -> None:
        from hannes.core.io.progress import progress_bar

        self.bar = progress_bar(
            total=total, disable=None if shown is None else not shown, file=sys.stderr, unit="run"
        )

    def __enter__(self) -> Callable[[Variant], Trajectory]:
        return self._run

    def __exit__(self, *_: object) -> None:
        self.bar.close()

    def _run(self, variant: Variant) -> Trajectory:
        self.bar.set_description(variant.name or variant.experiment.title)
        done = simulate(variant.hand, variant.experiment).require()
        self.bar.update()
        return done
