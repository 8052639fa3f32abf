"""Where the electrical energy of a run went: an account that must close."""

from dataclasses import replace

import numpy as np

from hannes.core.errors import BadInput
from hannes.simulation.experiment.experiment import Experiment
from hannes.simulation.hand.hand import Hand
from hannes.simulation.simulate import simulate
from hannes.simulation.trajectory import Trajectory

POWER = "power_"
COARSEST = 4000.0  # Hz; below this the trapezoids miss the quick parts of a grasp
FINE = 20_000.0  # Hz
ROUNDING = 1e-15  # J that a hand at rest may seem to take
MOST = 200_000  # samples, some 200 MB of outputs


def account(
    hand: Hand, experiment: Experiment, *, method: str = "Rodas", rtol: float = 1e-4
) -> dict[str, float]:
    """Simulate `experiment` once more, sampled finely enough, and return its energy ledger.

    Raises BadInput for a run that took no energy or lasts too long, ComputationFailed as
    `Trajectory.require` does.
    """
    sampling = min(FINE, MOST / experiment.duration)
    finely = replace(experiment, sampling=sampling)
    if sampling < COARSEST:
        raise BadInput(
            f"an energy ledger needs a run of at most {MOST / COARSEST:g} s, "
            f"this one takes {experiment.duration:g} s"
        )
    return energy_ledger(simulate(hand, finely, method=method, rtol=rtol).require())


def energy_ledger(trajectory: Trajectory) -> dict[str, float]:
    """Integrate every power output of a run: name -> J, and the share that is unaccounted for.

    `electrical` is what the drive put into the motor. Every other entry is what went into one
    part, stored or lost: copper, inductance, gear_friction, motor_torque (further torques on the
    rotor), cart_friction, joint_friction, wire_elastic, wire_damping, wire_friction, spring, stop,
    gravity, contact_normal, contact_tangential, object (into the motion of one that floats), and
    `kinetic` of the hand from the states themselves.
    `residual` [1] is what remains of `electrical` after
    all of them, as a share of it. Energies come from trapezoids between the samples, so the
    run must be sampled at 4 kHz or more (20 kHz for 0.1 %); raises BadInput otherwise, and
    for a run that took no energy.
    """
    time = trajectory.time
    if time.size < 2 or np.diff(time).max() > 1.001 / COARSEST:
        raise BadInput(
            f"an energy ledger needs samples at {COARSEST:g} Hz or more; "
            f"set the experiment's sampling (it is {trajectory.experiment.sampling:g} Hz)"
        )
    ledger = {
        slot.name.removeprefix(POWER): _integral(time, trajectory[slot.name])
        for slot in trajectory.compiled.outputs.slots
        if slot.name.startswith(POWER)
    }
    kinetic = trajectory["energy_kinetic"]
    ledger["kinetic"] = float(kinetic[-1] - kinetic[0])
    given = ledger["electrical"]
    if abs(given) < ROUNDING:
        raise BadInput("an energy ledger needs a run that takes energy; the motor took none")
    spent = sum(energy for name, energy in ledger.items() if name != "electrical")
    return {**ledger, "residual": (given - spent) / given}


def _integral(time: np.ndarray, power: np.ndarray) -> float:
    return float(np.trapezoid(power, time))
