"""All figures of the page, in its order."""

from hannes.report.figure import Drawn
from hannes.report.paper import figure_closure, figure_friction, figure_grasp, figure_study
from hannes.report.paper.runs import Runs


def figures(runs: Runs) -> dict[str, Drawn]:
    """Draw every figure, by name."""
    every = (
        figure_grasp.dynamometer(runs.rigid),
        figure_grasp.rigid_and_soft(runs.rigid, runs.soft),
        figure_closure.closure(runs.closure),
        figure_closure.void(runs.hands, runs.unit),
        figure_friction.friction(runs.hand),
        figure_study.stiffness(runs.sweep),
        figure_study.controllers(runs.rigid, runs.sampled),
    )
    return {each.name: each for each in every}
