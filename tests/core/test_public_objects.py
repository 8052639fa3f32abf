"""Every public object: a short repr, == by value (arrays too), and back from a pickle the same."""

import pickle
from dataclasses import replace

import numpy as np
import oven
import pytest
import sled

import hannes
from hannes import (
    Effect,
    Expected,
    Experiment,
    Hand,
    Parameter,
    Recording,
    Reference,
    Slot,
    Target,
    Term,
)
from hannes.core.io.toml_table import Table
from hannes.plants.axis.plant import EQUATIONS as axis_equations
from hannes.plants.axis.plant import Axis
from hannes.plants.finger.plant import EQUATIONS as finger_equations
from hannes.plants.finger.plant import Finger
from hannes.plants.hand.plant import HandPlant


def recording(position=0.5):
    time = np.arange(5) / 10.0
    return Recording({"time": time, "position": position * time}, {"time": "s", "position": "rad"})


def reference(end=1.0):
    return Reference([[0.0, 0.02], [0.0, end]])


def experiment(end=1.0):
    return Experiment("closing", 0.02, reference(end), Target("sphere", {"object.radius": 0.03}))


def verdict(seed):
    """Of the lighter way: the plant says of nothing that it is uncertain."""
    rail = sled.campaign(1 + seed)
    empty = Table({}, "campaign", ())
    return replace(rail, diagnose=empty, plant=Plain(), shipped=Plain())


class Plain(sled.Sled):
    """A sled that is diagnosed the lighter way."""

    uncertain = {}  # noqa: RUF012


def made(number):
    """Public objects, by what makes them; another number makes others of the same kind."""
    size = Parameter("size", 0.0, "N", (0.0, 1.0 + number), "of it", off=0.0)
    term = Term(sled.turbulence if number else sled.hardening, writes=("force",))
    shipped = list(hannes.effects().values())[number]
    hand = Hand(["leader_slack"]).with_values({"leader_slack.length": 1e-3 * (1 + number)})
    return {
        "BadInput": hannes.BadInput("expected more", (f"scale = {number}",)),
        "ComputationFailed": hannes.ComputationFailed(f"after {number} steps"),
        "Effect": Effect("it", "A test.", "F += f", "none", (replace(size, name="size"),), (term,))
        if number
        else sled.TURBULENCE,
        "Effect of the package": shipped,
        "Effect of another kernel": sled.TURBULENCE if number else sled.HARDENING,
        "Equations": (axis_equations, finger_equations)[number],
        "Expected": Expected(peak=(0.0, 1.0 + number)),
        "Experiment": experiment(1.0 + number),
        "Hand": hand,
        "Parameter": size,
        "ParameterSet": hand.parameters,
        "PlainPlant": sled.Sled().with_values({"sled.mass": 1.0 + number}),
        "CompiledPlant": Axis().with_values({"axis.mass": 90.0 + number}),
        "finger": Finger().with_values({"contact.angle": 4.0 + number}),
        "hand plant": HandPlant(hand),
        "Recording": recording(1.0 + number),
        "Reference": reference(1.0 + number),
        "Stepper": stepped(number),
        "Slot": Slot("speed", "m/s", "of it", size=1 + number),
        "Target": Target("sphere", {"object.radius": 0.02 + 0.01 * number}),
        "Term": term,
        "Variant": hannes.load_experiment("dynamometer")[0]
        if number
        else hannes.load_experiment("void-closure")[0],
        "finding": hannes.check(recording(1e3 * number), HandPlant()),
    }


def computed(number):
    """The same of what simulations and fits return."""
    hand, asked = Hand(), experiment(0.2 + 0.1 * number)
    rail = sled.campaign(1 + number)
    warm = oven.campaign(1 + number, {"oven.gain": 2.5}, parameters=["oven.gain"], starts=1)
    return {
        "Trajectory": hannes.simulate(hand, asked),
        "Grasp": next(hannes.simulate_many([(hand, asked)], progress=False)),
        "Diagnosis": (found := hannes.diagnose(rail, progress=False)),
        "Verdict": found.verdict,
        "Diagnosis without doubts": hannes.diagnose(verdict(number), progress=False),
        "Calibration": hannes.calibrate(warm, progress=False),
    }


def stepped(number):
    """A stepper after some ticks."""
    made = hannes.start(Hand(), experiment(0.5))
    for _ in range(1 + number):
        made.step()
    return made


SIMPLE = (  # of `made`
    "BadInput", "ComputationFailed", "Effect", "Effect of another kernel",
    "Effect of the package", "Equations", "Expected", "Experiment", "Hand", "Parameter",
    "ParameterSet", "PlainPlant", "Recording", "Reference", "Slot", "Stepper", "Target", "Term",
    "Variant", "CompiledPlant", "finding", "finger", "hand plant",
)  # fmt: skip
COMPUTED = (  # of `computed`
    "Calibration", "Diagnosis", "Diagnosis without doubts", "Grasp", "Trajectory", "Verdict",
)  # fmt: skip


@pytest.fixture(scope="module")
def objects():
    """Objects twice over, and others of the same kinds."""
    one, again, other = (made(number) | computed(number) for number in (0, 0, 1))
    assert sorted(one) == sorted((*SIMPLE, *COMPUTED))
    return {name: (one[name], again[name], other[name]) for name in one}


@pytest.mark.parametrize("name", (*SIMPLE, *COMPUTED))
def test_a_public_object_is_shown_compared_and_pickled_by_value(objects, name):
    one, again, other = objects[name]
    assert one == again and again == one and not one != again
    assert one != other and other != one and one != "a text" and one is not None
    shown = repr(one)
    assert 5 < len(shown) < 600 and "\n" not in shown and " at 0x" not in shown
    back = pickle.loads(pickle.dumps(one))
    assert type(back) is type(one) and back == one and back != other


def test_the_contract_looks_at_all_that_is_public():
    classes = {name for name in hannes.__all__ if isinstance(getattr(hannes, name), type)}
    errors = {name for name in classes if issubclass(getattr(hannes, name), Exception)}
    protocols = {"Plant"}
    assert classes - errors - protocols <= {*SIMPLE, *COMPUTED}


def test_an_effect_of_the_package_is_pickled_by_name_so_that_another_process_finds_it():
    packed = pickle.dumps(hannes.effects()["leader_slack"])
    assert b"hannes.dynamics.leader_slack:" in packed and len(packed) < 2000
