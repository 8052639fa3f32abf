"""How long eight parameters over six recordings take; beside it, with a stock solver."""

import time
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from benchmarks.calibrating.cases import NINE, case
from benchmarks.truth.protocol import DYNAMOMETER, PAPER, RICH, SOFT_BALL, Condition, Protocol
from hannes.commands.calibrate import Calibration, calibrate
from hannes.core.recording.recording import Recording
from hannes.plants.hand.plant import HandPlant
from hannes.simulation.experiment.experiment import Experiment
from hannes.simulation.integrate import METHODS
from hannes.simulation.simulate import simulate

SIX = Protocol(
    (
        Condition("void", PAPER, 2),
        Condition("dynamometer", PAPER, 2, DYNAMOMETER, sensor=True),
        Condition("soft ball", PAPER, 2, SOFT_BALL),
    ),
    RICH,
)
EIGHT = tuple(name for name in NINE if name != "pip.coulomb_friction")
STOCK = [name for name in METHODS if name in ("LSODA", "BDF", "Radau")]  # for stiff problems
TOLERANCE = 1e-6  # at which slopes by differences are right to a percent


class StockHand(HandPlant):
    """The hand, integrated by one of scipy's own methods."""

    method = "LSODA"

    def _run(
        self, parameters: Mapping[str, float], recording: Recording, experiment: Experiment
    ) -> dict[str, np.ndarray]:
        hand = self.hand.with_values(parameters)
        asked = replace(experiment, controller="continuous")  # tick by tick takes minutes
        run = simulate(hand, asked, method=self.method, rtol=TOLERANCE, effects=hand.effects)
        since = recording.time - recording.time[0]
        return {name: np.interp(since, run.time, run.require()[name]) for name in self.judged}


def timed(plant: HandPlant, starts: int, workers: int, seed: int = 1) -> dict[str, Any]:
    """Wall and processor seconds of one calibration after a warm-up of its model."""
    made = case(seed, EIGHT, SIX, starts=starts)
    campaign = replace(made.campaign, plant=plant, shipped=plant)
    plant.simulate({}, campaign.entries[0].recording)
    begun, spent = time.perf_counter(), time.process_time()
    found = calibrate(campaign, workers=workers, progress=False)
    return {
        "seconds": time.perf_counter() - begun,
        "processor_seconds": time.process_time() - spent,
        "worst_error_percent": 100.0 * _worst(found, made.true),
        "agree": all(found.agreeing),
    }


def _worst(found: Calibration, true: Mapping[str, float]) -> float:
    errors = [abs(e.value / true[e.name] - 1.0) for e in found.answers if e.identified]
    return max(errors, default=float("nan"))


def fastest() -> str:
    """The stock method that simulates the dynamometer grasp in the least time."""
    recording = case(1, EIGHT, SIX).campaign.entries[2].recording
    seconds = {}
    for method in STOCK:
        plant = StockHand()
        plant.method = method
        plant.simulate({}, recording)
        begun = time.process_time()
        plant.simulate({}, recording)
        seconds[method] = time.process_time() - begun
    return min(seconds, key=lambda name: seconds[name])


def rows(quick: bool) -> list[dict[str, Any]]:
    """Ours with four starts and with one; the best stock method with one."""
    found = [
        {"solver": "Rodas", "starts": n, "workers": 2, **timed(HandPlant(), n, 2)} for n in (4, 1)
    ]
    if quick:
        return found
    plant = StockHand()
    plant.method = fastest()
    return [*found, {"solver": plant.method, "starts": 1, "workers": 2, **timed(plant, 1, 2)}]
