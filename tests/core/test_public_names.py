"""The names that hannes shows, what its import costs, and files written for its former layout."""

import importlib.util
import inspect
import re
import runpy
import subprocess
import sys
import warnings
from dataclasses import fields, replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import hannes
from hannes.commands.diagnose import Diagnosis
from hannes.core import former_names
from hannes.core.effect import Term
from hannes.core.former_names import MOVED, MovedWarning
from hannes.identification.calibration.identifiability import Answer
from hannes.identification.calibration.result import Fit
from hannes.plants.protocol import find_plant
from hannes.simulation.catalogue import effect
from hannes.simulation.trajectory import Trajectory

PACKAGE = Path(hannes.__file__).parent
SHOWN = """
    BadInput CompiledPlant ComputationFailed Effect Equations Expected Experiment Hand Parameter
    PlainPlant Plant Recording Reference Slot Stepper Target Term calibrate check compare convert
    diagnose effects kernel load_experiment observe open_to_effects simulate simulate_many start
    view
""".split()

# Files as users wrote them for the former layout, cart.py and rail.py as they shipped then.
FORMER = Path(__file__).parent / "former_layout"
ADVICE = {
    "_jit": "kernel",
    "effect": "Effect, Term",
    "errors": "BadInput, ComputationFailed",
    "expected": "Expected",
    "experiment": "Experiment, Reference, Target",
    "hand": "Hand",
    "layout": "Slot",
    "observe": "observe",
    "parameter": "Parameter",
    "plain_plant": "PlainPlant",
    "simulate": "simulate",
}
IMPORT = re.compile(r"^from hannes\.\w+ import (.+)$", re.MULTILINE)


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
def folder(request, tmp_path, forgotten):
    """The files in a folder of their own; the public ones differ in their imports alone.

    What they warn of while they run is looked at afterwards.
    """
    for file in FORMER.iterdir():
        text = file.read_text(encoding="utf-8")
        if request.param == "public":
            text = IMPORT.sub(r"from hannes import \1", text)
        (tmp_path / file.name).write_text(text, encoding="utf-8")
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        yield tmp_path
    moved = [each for each in found if issubclass(each.category, DeprecationWarning)]
    if request.param == "public":
        assert not moved
        return
    assert {Path(each.filename).parent for each in moved} == {tmp_path}
    assert {str(each.message) for each in moved} == {
        f"hannes.{name} goes with the next release: "
        f"write from hannes import {public}, or hannes.{MOVED[name]}"
        for name, public in ADVICE.items()
    }


def test_a_plant_effects_and_experiments_of_a_users_own_run(folder):
    cart = find_plant("cart:Cart", folder)
    rail = effect("rail.py:RAIL_FRICTION", folder)
    time = np.arange(0.0, 1.0, 2e-3)
    units = {"time": "s", "push": "N"}
    recording = hannes.Recording({"time": time, "push": 0.0 * time + 6.0}, units)
    alone = cart.simulate({}, recording)["position"]
    rubbed = cart.with_effects(rail).simulate({"rail_friction.size": 0.6}, recording)["position"]
    assert np.abs(rubbed - alone).max() > 1e-3 and cart.phases(recording)["pushed"].all()
    (variant,) = hannes.load_experiment(folder / "rubbing.toml", trust=True)
    assert "rubbing__rub(" in variant.hand.equations()
    ran = runpy.run_path(str(folder / "script.py"))
    assert ran["recording"]["position"][-1] > 0.0
    assert all(inspect.isfunction(getattr(hannes, name)) for name in ("simulate", "observe"))


def test_the_names_are_those_shown_and_no_others():
    import hannes.core.effect  # and by that hannes.core becomes an attribute

    assert dir(hannes) == SHOWN == sorted(hannes.__all__)
    assert {getattr(hannes, name) is not None for name in SHOWN} == {True}
    assert (PACKAGE / "py.typed").is_file()


def test_importing_hannes_loads_nothing_of_weight():
    script = (
        "import sys; before = set(sys.modules); import hannes; print(*set(sys.modules) - before)"
    )
    run = subprocess.run([sys.executable, "-c", script], capture_output=True, check=True, text=True)
    loaded = run.stdout.split()
    own = [name for name in loaded if name.partition(".")[0] == "hannes"]
    assert len(own) <= 8
    assert {name.partition(".")[0] for name in loaded} - {"hannes"} <= set(sys.stdlib_module_names)


def test_every_former_module_is_somewhere_today():
    for name in MOVED.values():
        assert importlib.util.find_spec(f"hannes.{name}") is not None


@pytest.mark.parametrize("former", [*ADVICE, "assemble", "batch", "check", "finger.plant"])
def test_a_former_module_is_that_of_today(former, forgotten):
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        found = importlib.import_module(f"hannes.{former}")
    assert f"hannes.{MOVED[former]}" in str(said[-1].message)
    assert found is importlib.import_module(f"hannes.{MOVED[former]}")
    assert found.__spec__.name == f"hannes.{MOVED[former]}"
    for name in ("simulate", "check", "convert", "calibrate", "diagnose", "observe"):
        assert inspect.isfunction(getattr(hannes, name))


def test_former_comments_of_equations_are_todays_statements(tmp_path, monkeypatch):
    from hannes.plants.axis import plant as axis

    written = Path(axis.EQUATIONS.module.__file__).read_text(encoding="utf-8")
    former, count = re.subn(r"(?m)^( *)(\S.*?) = effects\(\2\)$", r"\1# effects: \2", written)
    (tmp_path / "former_equations.py").write_text(former, encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.warns(MovedWarning, match="write `a, b = effects"):
        found = replace(axis.EQUATIONS, module=importlib.import_module("former_equations"))
        assert count > 3 and found.source() == axis.EQUATIONS.source()


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


TYPED = """
from hannes import Effect, Experiment, Hand, Parameter, Recording, Reference, Term
from hannes import kernel, observe, simulate


@kernel
def drag(motor_speed: float, size: float) -> float:
    return size * motor_speed


own = Effect(
    "drag", "A test.", "-", "none", (Parameter("size", 0.0, "N m s/rad", (0.0, 1.0), "", off=0.0),),
    (Term(drag, ("gear_friction",)),),
)
hand = Hand([own]).with_values({"drag.size": 1e-6})
run = simulate(hand, Experiment("a start", 0.1, Reference([[0.0, 0.1], [0.0, 1.0]])))
recording: Recording = observe(hand, run)
peaks: dict[str, float] = {name: float(values.max()) for name, values in recording.items()}
wrong: int = recording.time
"""


@pytest.mark.slow
def test_a_users_types_are_checked_against_those_of_hannes(tmp_path):
    api = pytest.importorskip("mypy.api")
    (tmp_path / "typed.py").write_text(TYPED, encoding="utf-8")
    (tmp_path / "mypy.ini").write_text("[mypy]\nstrict = true\n", encoding="utf-8")
    options = ["--config-file", str(tmp_path / "mypy.ini"), "--cache-dir", str(tmp_path / "cache")]
    found, _, _ = api.run([*options, str(tmp_path / "typed.py")])
    lines = [line for line in found.splitlines() if "typed.py" in line]
    assert len(lines) == 1 and "Incompatible types in assignment" in lines[0]


def test_an_effect_on_a_channel_by_its_former_name_adds_to_the_present_one():
    def shifted(told_force, size):
        return size * told_force

    with pytest.warns(MovedWarning, match="write logged_force"):
        term = Term(shifted, writes=("told_force",))
        assert term.writes == ("logged_force",) and term.arguments == ("logged_force", "size")


@pytest.mark.parametrize(
    ("owner", "former", "today"),
    [
        (Diagnosis, "floors", "noise_floors"),
        (Diagnosis, "deep", "details"),
        (Fit, "remains", "repeatable_residual"),
        (Fit, "findings", "data_issues"),
        (Answer, "given", "nominal"),
        (Trajectory, "holds", "memories"),
    ],
)
def test_former_attributes_are_read_with_a_warning(owner, former, today):
    assert today in {each.name for each in fields(owner)}
    with pytest.warns(MovedWarning, match=f"{owner.__name__}.{former} .* write {today}$"):
        assert getattr(owner, former).fget(SimpleNamespace(**{today: 7})) == 7
