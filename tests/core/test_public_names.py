"""The names that hannes shows, what its import costs, and files written for its former layout."""

import inspect
import re
import runpy
import subprocess
import sys
import textwrap
import warnings
from pathlib import Path

import numpy as np
import pytest

import hannes
from hannes.core import former_names
from hannes.core.former_names import MOVED, MovedWarning
from hannes.plants.protocol import find_plant
from hannes.simulation.catalogue import effect

PACKAGE = Path(hannes.__file__).parent
SHOWN = """
    BadInput ComputationFailed Effect Expected Experiment Hand Parameter PlainPlant Plant Recording
    Reference Slot Target Term calibrate check convert diagnose effects kernel load_experiment
    observe simulate simulate_many
""".split()

CART = """
import numpy as np

{imports}


class Cart(PlainPlant):
    name = "cart"
    channels = {{"time": "s", "push": "N", "position": "m"}}
    required = ("push",)
    judged = ("position",)
    base = (Parameter("spring.stiffness", 90.0, "N/m", (1.0, 1e3), "of the spring", "data sheet"),)
    free = {{"spring.stiffness": 9.0}}
    block = 0.5
    open = {{"friction": ("speed", "position")}}
    expected = {{"push": Expected(drives="position", peak=(0.1, 100.0))}}

    def simulate(self, parameters, recording):
        values = self.parameters.with_values(parameters)
        friction = self.added("friction", parameters)
        x = v = 0.0
        positions = [x]
        for h, push in zip(np.diff(recording.time), recording["push"][:-1], strict=True):
            v += h * (push - values["spring.stiffness"] * x - friction(v, x))
            x += h * v
            positions.append(x)
        if not np.isfinite(x):
            raise ComputationFailed("the cart runs away; sample its push more often")
        return {{"position": np.array(positions)}}

    def phases(self, recording):
        return {{"all": np.ones(len(recording), bool)}}
"""
RAIL = """
import math

{imports}


@kernel
def dry(speed, size):
    return size * math.tanh(speed / 5e-3)


RAIL_FRICTION = Effect(
    name="rail_friction",
    meaning="The rail rubs: a force against the motion that does not grow with speed.",
    equation="m x'' = push - k x - c x' - size tanh(x' / 5 mm/s)",
    source="Coulomb 1785, its corner rounded",
    parameters=(Parameter("size", 0.0, "N", (0.0, 5.0), "of the friction", off=0.0),),
    terms=(Term(dry, writes=("friction",)),),
)
"""
SCRIPT = """
{imports}

hand = Hand().with_values({{"motor.resistance": 0.5}})
reference = Reference([[0.0, 0.02], [0.0, 0.2]])
run = simulate(hand, Experiment("a start", 0.02, reference))
recording = observe(hand, run)
"""
FORMER = {
    "cart.py": """
        from hannes.errors import ComputationFailed
        from hannes.expected import Expected
        from hannes.parameter import Parameter
        from hannes.plain_plant import PlainPlant
    """,
    "rail.py": """
        from hannes._jit import kernel
        from hannes.effect import Effect, Term
        from hannes.parameter import Parameter
    """,
    "script.py": """
        from hannes.experiment import Experiment, Reference
        from hannes.hand import Hand
        from hannes.observe import observe
        from hannes.simulate import simulate
    """,
}
PUBLIC = {
    "cart.py": "from hannes import ComputationFailed, Expected, Parameter, PlainPlant",
    "rail.py": "from hannes import Effect, Parameter, Term, kernel",
    "script.py": "from hannes import Experiment, Hand, Reference, observe, simulate",
}
TEXTS = {"cart.py": CART, "rail.py": RAIL, "script.py": SCRIPT}


@pytest.fixture
def forgotten():
    """Former modules, and those of users' files, as if nobody had asked for them yet."""

    def forget():
        for name in list(sys.modules):
            if name == "cart" or name.startswith("hannes_own_") or name in former:
                del sys.modules[name]

    former = {f"hannes.{name}" for name in MOVED}
    forget()
    yield
    forget()


@pytest.fixture(params=["former", "public"])
def written(request, tmp_path, forgotten):
    """A folder with the files, and the warnings that they give when they run."""
    imports = FORMER if request.param == "former" else PUBLIC
    for name, text in TEXTS.items():
        filled = text.format(imports=textwrap.dedent(imports[name]).strip())
        (tmp_path / name).write_text(filled, encoding="utf-8")
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        yield tmp_path, caught
    asked = {MOVED[name] for text in FORMER.values() for name in re.findall(r"hannes\.(\w+)", text)}
    moved = [str(each.message) for each in caught if each.category is MovedWarning]
    if request.param == "public":
        assert not moved
        return
    for each in caught:
        assert Path(each.filename).parent == tmp_path and issubclass(
            each.category, DeprecationWarning
        )
    for today in set(re.findall(r"hannes\.([a-z_.]+)$", "\n".join(moved), re.MULTILINE)):
        assert today in asked
    assert moved and all("write from hannes import " in each for each in moved)


def test_a_plant_its_effect_and_an_experiment_of_a_users_own_run(written):
    folder, _ = written
    cart = find_plant("cart:Cart", folder)
    rail = effect("rail.py:RAIL_FRICTION", folder)
    time = np.arange(0.0, 1.0, 2e-3)
    units = {"time": "s", "push": "N"}
    recording = hannes.Recording({"time": time, "push": 0.0 * time + 6.0}, units)
    alone = cart.simulate({}, recording)["position"]
    rubbed = cart.with_effects(rail).simulate({"rail_friction.size": 0.6}, recording)["position"]
    assert np.abs(rubbed - alone).max() > 1e-3 and cart.phases(recording)["all"].all()
    ran = runpy.run_path(str(folder / "script.py"))
    assert ran["recording"]["position"][-1] > 0.0
    assert all(inspect.isfunction(getattr(hannes, name)) for name in ("simulate", "observe"))


def test_the_names_are_those_shown_and_no_others():
    import hannes.core.effect  # and by that hannes.core becomes an attribute

    assert dir(hannes) == SHOWN == sorted(hannes.__all__)
    assert {getattr(hannes, name) is not None for name in SHOWN} == {True}
    assert (PACKAGE / "py.typed").is_file()


def test_importing_hannes_loads_nothing_of_weight():
    script = "import hannes, sys; print(*(m for m in sys.modules if m[:6] in ('hannes', 'numpy')))"
    run = subprocess.run([sys.executable, "-c", script], capture_output=True, check=True, text=True)
    assert run.stdout.split() == [
        "hannes.core",
        "hannes.core.former_names",
        "hannes.core.version",
        "hannes",
    ]


@pytest.mark.parametrize("former", MOVED)
def test_a_former_module_is_that_of_today(former, forgotten):
    import importlib

    with pytest.warns(MovedWarning, match=re.escape(f"hannes.{MOVED[former]}")):
        found = importlib.import_module(f"hannes.{former}")
    assert found is importlib.import_module(f"hannes.{MOVED[former]}")
    assert found.__spec__.name == f"hannes.{MOVED[former]}"
    for name in ("simulate", "check", "convert", "calibrate", "diagnose", "observe"):
        assert inspect.isfunction(getattr(hannes, name))


def test_a_name_that_never_was_is_not_found():
    assert former_names.Finder.find_spec("hannes.efect") is None
    assert former_names.Finder.find_spec("other.effect") is None
    with pytest.raises(AttributeError, match="no attribute 'efect'"):
        hannes.efect  # noqa: B018


def test_a_command_line_shows_the_warning_without_being_asked_to(tmp_path):
    (tmp_path / "mine.py").write_text("import hannes.effect\n", encoding="utf-8")
    script = "import hannes, sys; sys.path.insert(0, sys.argv[1]); import mine"
    command = [sys.executable, "-c", script, str(tmp_path)]
    caught = subprocess.run(command, capture_output=True, text=True, check=True).stderr
    line = caught.splitlines()[0]
    assert line.startswith(str(tmp_path / "mine.py:1: "))
    assert line.endswith("write from hannes import Effect, Term, or hannes.core.effect")
