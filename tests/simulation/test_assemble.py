"""Effects and plants from outside the package; machine code that is never older than its source."""

import importlib.util
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from runs import grasp, worst

import hannes
from hannes.core.effect import Effect, Term
from hannes.core.errors import BadInput
from hannes.core.layout import Layout, Slot
from hannes.core.parameter import Parameter
from hannes.simulation.catalogue import effect as find_effect
from hannes.simulation.compiler.assemble import Equations, assemble
from hannes.simulation.hand.hand import Hand
from hannes.simulation.hand.model import EQUATIONS
from hannes.simulation.simulate import simulate

OWN = '''
"""Effects of a user's own."""
from hannes.core.kernels.jit import kernel
from hannes.core.effect import Effect, Term
from hannes.core.layout import Slot
from hannes.core.parameter import Parameter


@kernel
def warmed(motor_current, temperature, gain, time_constant):
    return gain * temperature, (motor_current**2 - temperature) / time_constant


@kernel
def stiffened(joint_angle, rest, joint_spring_stiffness, share):
    return share * joint_spring_stiffness * (joint_angle - rest)


WARM = Effect(
    name="warm_winding",
    meaning="The winding warms with the square of its current.",
    equation="R += gain T; T' = (i^2 - T) / time_constant",
    source="a test",
    parameters=(
        Parameter("gain", 0.0, "ohm/K", (0.0, 10.0), "per kelvin", off=0.0),
        Parameter("time_constant", 0.2, "s", (1e-3, 1e3), "of the winding"),
    ),
    terms=(Term(warmed, writes=("resistance",), states=("temperature",)),),
    states=(Slot("temperature", "K", "above rest", tolerance=1e-3),),
)
STIFF = Effect(
    name="stiff_springs",
    meaning="The re-opening springs are stiffer than their nominal values.",
    equation="T_spring += share k (q - q_rest)",
    source="a test",
    parameters=(Parameter("share", 0.0, "1", (-0.9, 9.0), "of the stiffness", off=0.0),),
    terms=(Term(stiffened, writes=("spring_torque",)),),
)
'''


@pytest.fixture(scope="module")
def own(tmp_path_factory):
    """File of the user's own effects."""
    path = tmp_path_factory.mktemp("own") / "own.py"
    path.write_text(OWN)
    return path


@pytest.fixture(scope="module")
def dressed(own):
    """The hand with both of the user's effects."""
    return Hand([f"{own}:WARM", f"{own}:STIFF"])


JOINTS = ("mcp", "pip")


def short(hand):
    """The start of a free closure with both effects compiled in."""
    experiment = grasp(None, 0.15)
    return simulate(hand, experiment, rtol=1e-8, effects=hand.effects).require()


@pytest.mark.slow
def test_an_own_effect_over_all_joints_works(dressed):
    """Springs stiffened by the effect equal springs that are stiffer."""
    mine = short(dressed.with_values({"stiff_springs.share": 0.5}))
    shipped = dressed.parameters
    stiff = {f"{j}.spring_stiffness": 1.5 * shipped[f"{j}.spring_stiffness"] for j in JOINTS}
    theirs = short(dressed.with_values(stiff))
    soft = short(dressed)
    for name in ("motor_angle", "joint_angle", "cart_position"):
        assert np.abs(mine[name] - theirs[name]).max() < 1e-6 * np.ptp(theirs[name])
    assert worst(mine["joint_angle"], soft["joint_angle"]) > 1e-3


def test_an_own_effect_with_a_state_works(dressed):
    """The state obeys its equation: T = int exp(-(t - s) / tau) i(s)^2 ds / tau."""
    found = short(dressed.with_values({"warm_winding.gain": 2.0}))
    temperature, current, time = found["warm_winding.temperature"], found["current"], found.time
    assert temperature[0] == 0.0 and temperature[-1] > 0.005
    weight = np.exp(-(time[-1] - time) / 0.2) / 0.2
    assert temperature[-1] == pytest.approx(np.trapezoid(weight * current**2, time), rel=2e-3)
    resistance = found["power_copper"][1:] / current[1:] ** 2
    expected = dressed.parameters["motor.resistance"] + 2.0 * temperature[1:]
    assert resistance == pytest.approx(expected, rel=1e-9)


def test_an_own_effect_is_loaded_once(own):
    assert find_effect(f"{own}:WARM") is find_effect("own.py:WARM", own.parent)


def test_own_effects_at_off_change_nothing(dressed):
    bare = simulate(Hand(), grasp(None, 0.15), rtol=1e-8).require()
    for name in ("current", "joint_angle", "leader_tension"):
        assert np.abs(short(dressed)[name] - bare[name]).max() <= 1e-6 * np.ptp(bare[name])


def test_equations_show_the_effects_call(own):
    hand = Hand([f"{own}:WARM", f"{own}:STIFF", "leader_slack"])
    values = {"warm_winding.gain": 1.0, "stiff_springs.share": 0.1, "leader_slack.length": 1e-3}
    text = hand.with_values(values).equations()
    assert "leader_slack__free_length(p[" in text
    assert "warm_winding__warmed(" in text and "stiff_springs__stiffened(" in text
    after = text[text.index("# effects: slack") :].splitlines()
    assert after[1].startswith("    if p[") and "slack += leader_slack__free_length(" in after[2]
    assert "leader_slack" not in hand.equations()


# --- refused ----------------------------------------------------------------------------------

REFUSED = {
    "reads_unknown": ("('slack',)", "nowhere", "nowhere"),
    "writes_unknown": ("('wobble',)", "share", "wobble"),
}


def adding(channel, *names):
    """An effect that adds to a channel what it reads."""
    kernel = eval(f"lambda {', '.join(names)}, share: 0.0")
    share = Parameter("share", 0.0, "1", (0.0, 1.0), "share", off=0.0)
    return Effect("odd", "An odd one.", "-", "a test", (share,), (Term(kernel, (channel,)),))


@pytest.mark.parametrize(
    "channel, name, why",
    [
        ("resistance", "excursion", "is not yet assigned"),  # filled by a stage to come
        ("reading_age", "excursion", "is not yet assigned"),  # a tick of its own
        ("spring_torque", "joint_torque", "is not yet assigned"),  # further on in its stage
        ("gear_friction", "tendon_tension", "is not yet assigned"),  # but for the thumb's
        ("logged_force", "torque_mcp", "is not yet assigned"),  # only where something touches
        ("gear_friction", "voltage", "is not at hand"),  # a local of another stage
        ("gear_friction", "leader_tension", "is not at hand"),
        ("joint_friction", "leader_stretch", "is not at hand"),
    ],
)
def test_an_effect_reads_nothing_from_before(channel, name, why):
    assert why in EQUATIONS.accepts(adding(channel, name))
    with pytest.raises(BadInput, match=why):
        assemble(EQUATIONS, (adding(channel, name),))


@pytest.mark.parametrize(
    "channel, names",
    [
        ("gear_friction", ["leader_pull", "excursion_rate", "load", "torque_constant"]),
        ("joint_torque", ["tendon_tension", "stop_torque", "joint_torque"]),
        ("normal_force", ["penetration", "normal_x", "slip_speed"]),
        ("logged_force", ["normal_force", "place"]),
        ("leader_tension", ["stiffness", "rate"]),
    ],
)
def test_an_effect_reads_what_is_assigned(channel, names):
    assert EQUATIONS.accepts(adding(channel, *names)) == ""


@pytest.mark.parametrize("case", REFUSED)
def test_an_effect_that_names_an_unknown_channel_is_refused(tmp_path, case):
    writes, argument, named = REFUSED[case]
    path = tmp_path / "bad.py"
    path.write_text(f"""
from hannes.core.kernels.jit import kernel
from hannes.core.effect import Effect, Term
from hannes.core.parameter import Parameter

@kernel
def odd({argument}, share{"d" if argument == "share" else ""}):
    return 0.0

BAD = Effect(
    "bad", "A bad one.", "none", "a test",
    (Parameter("share", 0.0, "1", (0.0, 1.0), "share", off=0.0),),
    (Term(odd, {writes}),),
)
""")
    hand = Hand([f"{path}:BAD"]).with_values({"bad.share": 0.5})
    with pytest.raises(BadInput) as refusal:
        hand.compiled()
    text = str(refusal.value)
    assert "bad" in text and named in text and "\n" not in text


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("leader_slak", "leader_slack"),
        ("nowhere.py:EFFECT", "nowhere.py"),
        ("own.py:NONE", "has nothing named NONE"),
        ("broken.py:EFFECT", "does not run"),
    ],
)
def test_effects_that_cannot_be_found_are_refused(own, name, expected):
    (own.parent / "broken.py").write_text("1 / 0\n")
    with pytest.raises(BadInput, match=expected) as refusal:
        find_effect(name, own.parent)
    assert "\n" not in str(refusal.value)


# --- machine code is never stale --------------------------------------------------------------

PLANT = {
    "plant.py": '''
"""A mass on a spring: a plant of the user's own."""
from springs import restoring
from hannes.core.kernels.insertion import effects
from hannes.dynamics.friction import dry


def equations(t, y, dy, p, c, reference, memory, out):
    push = 0.0
    push = effects(push)
    dy.place = y.speed
    dy.speed = push - restoring(y.place, p.stiffness) - dry(y.speed, p.level, 1.0)


def sample(t, y, dy, p, c, reference, memory, out):
    memory[0] = 0.0
''',
    "springs.py": """
from hannes.core.kernels.jit import kernel


@kernel
def restoring(place, stiffness):
    return 1.0 * stiffness * place
""",
    "own.py": """
from helper import scaled
from numbers_of_mine import WEIGHT
import more_numbers
from hannes.core.kernels.jit import kernel
from hannes.core.effect import Effect, Term
from hannes.core.parameter import Parameter

@kernel
def inner(place):
    return scaled(place) * WEIGHT


@kernel
def drive(place, share):
    return share * inner(place) + more_numbers.OFFSET


EFFECT = Effect(
    "own", "It pushes.", "push += share place", "a test",
    (Parameter("share", 0.0, "1", (0.0, 10.0), "share", off=0.0),),
    (Term(drive, ("push",)),),
)
""",
    "helper.py": """
from hannes.core.kernels.jit import kernel


@kernel
def scaled(x):
    return 1.0 * x
""",
    "numbers_of_mine.py": "WEIGHT = 1.0\n",
    "more_numbers.py": "OFFSET = 0.0\n",
    "run.py": """
import json
import os
import sys
from pathlib import Path
import numpy as np
from hannes.simulation.compiler.assemble import Equations, assemble
from hannes.simulation.catalogue import effect
from hannes.core.layout import Layout, Slot


def layout(*names):
    return Layout(tuple(Slot(name, "1", "of the test") for name in names))


def run():
    import plant

    written = Equations(
        plant, layout("stiffness", "level"), layout("place", "speed"), layout("push"),
        layout("force"),
    )
    model = assemble(written, (effect("own.py:EFFECT"),))
    given = np.array([1.0, 100.0]), np.array([3.0, 2.0, 5.0]), np.zeros((2, 2)), np.zeros(7)
    print(json.dumps([model.is_warm(), *model.fast.rates(0.0, *given)]), flush=True)


for name, old, new in json.loads(sys.argv[1]):
    text = Path(name).read_text()
    Path(name).write_text(text.replace(old, new))
    child = os.fork()  # a process that knows nothing of the plant
    if child == 0:
        run()
        os._exit(0)
    assert os.waitpid(child, 0)[1] == 0
    Path(name).write_text(text)
""",
}
# rate of the speed: 5 WEIGHT + OFFSET - 3 - 2 tanh(100)
PLAIN = 5.0 - 3.0 - 2.0
EDITS = [
    ("own.py", "return scaled(place) * WEIGHT", "return 3.0 * scaled(place) * WEIGHT", 15.0 - 5.0),
    ("helper.py", "return 1.0 * x", "return 4.0 * x", 20.0 - 5.0),
    ("numbers_of_mine.py", "WEIGHT = 1.0", "WEIGHT = 5.0", 25.0 - 5.0),
    ("more_numbers.py", "OFFSET = 0.0", "OFFSET = 7.0", 12.0 - 5.0),
    ("springs.py", "return 1.0 *", "return 2.0 *", 5.0 - 8.0),
]


AS_IT_IS = ("plant.py", "", "")


def ran(folder, package, edits=(AS_IT_IS,)):
    """Run the plant with each edit in a process of its own, forked from one that has hannes.

    Of each: was machine code at hand, rate of the speed.
    """
    done = subprocess.run(
        [sys.executable, "run.py", json.dumps(edits)],
        cwd=folder,
        env={
            **os.environ,
            "HANNES_CACHE": str(folder / "cache"),
            "PYTHONPATH": os.pathsep.join([str(folder), str(package)]),
            "PYTHONDONTWRITEBYTECODE": "1",
        },
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return [(warm, rate) for warm, _, rate in map(json.loads, done.stdout.splitlines())]


@pytest.fixture
def plant(tmp_path):
    """Folder with a plant and an effect of the user's own."""
    for name, text in PLANT.items():
        (tmp_path / name).write_text(text)
    return tmp_path


PACKAGE = Path(hannes.__file__).parent


def test_edits_outside_the_package_never_run_stale_machine_code(plant):
    edits = [AS_IT_IS, AS_IT_IS, *(edit[:3] for edit in EDITS)]
    assert all(old in (plant / name).read_text() for name, old, _ in edits)
    found = ran(plant, PACKAGE.parent, edits)
    assert found[:2] == [(False, PLAIN), (True, PLAIN)]
    for (_, rate), (name, _, new, expected) in zip(found[2:], EDITS, strict=True):
        assert rate == expected, f"{name}: {new}"


def test_an_edit_of_the_package_never_runs_stale_machine_code(plant):
    copy = plant / "copied"
    shutil.copytree(PACKAGE, copy / "hannes", ignore=shutil.ignore_patterns("__pycache__"))
    assert ran(plant, copy) == [(False, PLAIN)]
    friction = copy / "hannes" / "dynamics" / "friction.py"
    text = friction.read_text()
    assert "return level * soft_sign" in text
    friction.write_text(text.replace("return level * soft_sign", "return 3.0 * level * math.tanh"))
    assert ran(plant, copy) == [(False, PLAIN - 4.0)]


READ_BACK = '''
def equations(t, y, dy, p, c, reference, memory, out):
    """An output filled, then read."""
    out.goal = 2.0 * y.place
    out.reached[0] = y.place
    dy.place = out.goal - y.place
'''


def test_an_output_that_is_read_back_is_refused(tmp_path):
    file = tmp_path / "read_back.py"
    file.write_text(READ_BACK)
    spec = importlib.util.spec_from_file_location("read_back", file)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    place = Layout((Slot("place", "m", "of the test"),))
    outputs = Layout((Slot("goal", "m", "of the test"), Slot("reached", "m", "of the test")))
    with pytest.raises(BadInput, match=r"read_back.py: out.goal is read, and outputs are only"):
        assemble(Equations(module, place, place, place, outputs))
