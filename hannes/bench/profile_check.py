"""The library's own limit: a command that breaks limits in simulation is never sent."""

from collections.abc import Callable

from hannes.bench.board_logic import Limits
from hannes.core.errors import BadInput
from hannes.simulation.experiment.experiment import Experiment
from hannes.simulation.hand.hand import Hand


def require_within(
    hand: Hand,
    experiment: Experiment,
    limits: Limits | None = None,
    progress: Callable[[str], None] = lambda text: None,
) -> None:
    """Raise BadInput where current [A] or shaft angle [rad] leave `limits` in simulation.

    The command runs on the stepper with the experiment's own object.
    """
    from dataclasses import replace

    from hannes.simulation.stepper import start

    given = limits or Limits()
    sampled = replace(experiment, controller="sampled")
    for angle in experiment.reference.knots[1]:
        if not given.travel_low <= angle <= given.travel_high:
            raise BadInput(
                f"{experiment.title}: its command goes to {angle:g} rad; the limit is "
                f"{given.travel_low:g} to {given.travel_high:g} rad. Nothing was sent"
            )
    progress("simulating the command first, against the limits")
    stepper = start(hand, sampled, rtol=1e-3)
    while stepper.time < experiment.duration:
        _check(experiment.title, stepper.step(), given)


def _check(title: str, now: dict[str, float], limits: Limits) -> None:
    if abs(now["current"]) > limits.current:
        raise BadInput(
            f"{title}: in simulation the current reaches {now['current']:.1f} A; the limit is "
            f"{limits.current:g} A. Nothing was sent"
        )
    if not limits.travel_low <= now["position"] <= limits.travel_high:
        raise BadInput(
            f"{title}: in simulation the shaft reaches {now['position']:.1f} rad; the limit is "
            f"{limits.travel_low:g} to {limits.travel_high:g} rad. Nothing was sent"
        )
