"""Outputs that are asked for alone: only what they need runs, and they are the same to the bit."""

import numpy as np
import pytest

from hannes import Hand, effects, load_experiment, simulate, simulate_many
from hannes.core.effect import Effect, Term
from hannes.core.kernels.jit import kernel
from hannes.core.layout import Layout, Slot
from hannes.core.parameter import Parameter
from hannes.simulation.compiler.expansion import Layouts
from hannes.simulation.compiler.output_slice import ProgramSlice, guarded
from hannes.simulation.hand.model import EQUATIONS

CATALOGUE = tuple(each for each in effects().values() if not EQUATIONS.accepts(each))
OUT = Layout((Slot("a", "1", ""), Slot("b", "1", "", "finger", 5), Slot("z", "1", "")))


def stages(needed: ProgramSlice, *names: str) -> list[int]:
    columns = [k for name in names for k in range(OUT[name].start, OUT[name].stop)]
    return np.flatnonzero(needed.by(columns)).tolist()


def of(*lines: str, others: str = "") -> ProgramSlice:
    body = "\n".join("    " + line for line in lines)
    head = "def equations(t, y, dy, p, c, reference, memory, out):\n"
    return ProgramSlice.of(head + body + "\n\n\n" + others, OUT)


def test_what_is_written_through_locals_slots_and_stages_is_followed_back():
    filling = "def fill(y, c):\n    for f in range(5):\n        c[3 + f] = y[f]\n"
    needed = of(
        *("x = y[0] + t", "fill(y, c)", "out[0] = x", "dy[0] = 1.0"),
        *("for f in range(5):\n        out[1 + f] = c[3:8][f]", "out[6] = dy[0]"),
        others=filling,
    )
    assert stages(needed, "a") == [0, 2]
    assert stages(needed, "b") == [1, 4]
    assert stages(needed, "z") == [3, 5]
    assert stages(needed, "a", "z") == [0, 2, 3, 5]
    assert stages(needed) == []


def test_what_is_added_to_counts_as_read_only_by_who_reads_it():
    needed = of("c[0] = 1.0", "c[0] += y[0]", "out[0] = c[1]", "out[6] = c[0]", "c[1] = 2.0")
    assert stages(needed, "a") == [2, 4]
    assert stages(needed, "z") == [0, 1, 3]


@pytest.mark.parametrize("line", ["out[0] = whole(c)", "out[0] = c[k]", "out[0] = c.sum()"])
def test_an_array_taken_as_a_whole_needs_all_that_writes_to_it(line):
    assert stages(of("c[0] = 1.0", "c[4] = 2.0", line, "out[6] = 0.0"), "a") == [0, 1, 2]


def test_an_array_that_is_handed_to_who_knows_whom_may_be_written_there():
    assert stages(of("unknown(c)", "out[0] = c[2]"), "a") == [0, 1]


def filled(*chosen: Effect) -> str:
    parts = (EQUATIONS.parameters, EQUATIONS.states, EQUATIONS.channels, EQUATIONS.outputs)
    return Layouts(*parts, chosen).expanded(EQUATIONS.source())


@pytest.mark.parametrize(
    "lines",
    [
        ["v = np.zeros(3)", "v[0] = y[0]", "out[0] = v[0]"],
        ["v = c[2:5]", "v[0] = 1.0", "out[0] = c[2 + 1]"],
        ["memory[9] = 2.0", "out[0] = memory[9]"],
        ["t = t + 1.0", "out[0] = t"],
        ["x = y[0]", "out[0] = logged(t, k=x)"],
        ["named(y, c)", "out[0] = c[2]"],
        ["unknown(c[2:5])", "out[0] = c[2]"],
        ["c[2:5].fill(0.0)", "out[0] = c[2]"],
        ["x = y[0]", "x = (x, 1.0)", "out[0] = x[0]"],
        ["if t > 1.0:\n        return", "out[0] = 1.0"],
    ],
)
def test_text_that_is_not_followed_runs_as_a_whole(lines):
    others = "def named(y, chan):\n    chan[2] = 1.0\n\n\ndef logged(t, k):\n    return k\n"
    assert of(*lines, others=others).statements == ()
    body = "\n".join("    " + line for line in lines)
    text = f"def equations(t, y, dy, p, c, reference, memory, out):\n{body}\n\n\n{others}"
    assert "if needed" not in guarded(text)
    assert "memory, out, needed):" in guarded(text)


def test_a_signature_of_any_form_takes_what_is_needed():
    text = guarded(
        "def equations(\n    t, y, dy, p,\n    c, reference, memory, out,\n) -> None:  # all\n"
        '    """Fill."""\n    a = 1.0; out[0] = a\n'
    )
    ran = {}
    exec(text, ran)
    out = [0.0]
    ran["equations"](0.0, [], [], [], [], [], [], out, [False, False])
    assert out == [0.0]
    ran["equations"](0.0, [], [], [], [], [], [], out, [True, True])
    assert out == [1.0]


def test_every_statement_of_the_equations_is_under_its_condition():
    text = guarded(filled())
    for n in range(len(ProgramSlice.of(filled(), EQUATIONS.outputs).statements)):
        assert text.count(f"    if needed[{n}]:\n") == 1
    assert text.count("out, needed):") == text.count("needed):") == 1


@pytest.mark.parametrize("chosen", [(), CATALOGUE], ids=["hand", "catalogue"])
def test_the_motor_s_channels_need_no_fingers_and_forces_no_motor(chosen):
    needed, out = ProgramSlice.of(filled(*chosen), EQUATIONS.outputs), EQUATIONS.outputs
    force, current = (needed.by([out[name].start]) for name in ("force", "current"))
    assert current.sum() == 1  # sense
    assert force.sum() == 2  # kinematics, contact
    assert not (force & current).any()


@kernel
def borrowed(tendon_tension, share):
    """Newtons more on a phalanx by its finger's wire."""
    return share * tendon_tension


@kernel
def overseeing(c, share):
    """Newtons more on all phalanges by whatever there is."""
    return share * c[0]


def pressing(function) -> Effect:
    share = Parameter("share", 0.0, "1", (0.0, 1.0), "share", off=0.0)
    terms = (Term(function, ("normal_force",)),)
    return Effect("pressing", "Presses by another stage.", "-", "a test", (share,), terms)


@pytest.mark.parametrize("function", [borrowed, overseeing])
def test_an_effect_that_reads_another_stage_has_that_stage_run(function):
    force = [EQUATIONS.outputs["force"].start]
    plain, more = (
        ProgramSlice.of(text, EQUATIONS.outputs).by(force)
        for text in (filled(), filled(pressing(function)))
    )
    assert more.sum() > plain.sum()
    assert more[plain].all()


@pytest.mark.slow
def test_each_output_asked_for_alone_is_the_same_to_the_bit():
    sizes = {
        effect.full_name(each.name): each.off + 0.01 * (each.bounds[1] - each.off)
        for effect in CATALOGUE
        for each in effect.amplitudes
        if each.off is not None
    }
    for hand in (Hand(), Hand(CATALOGUE).with_values(sizes)):
        experiment = load_experiment("soft-ball")[0].experiment
        whole = simulate(hand, experiment, rtol=1e-3)
        for slot in whole.compiled.outputs.slots:
            (alone,) = simulate_many([(hand, experiment)], channels=[slot.name], rtol=1e-3)
            assert np.array_equal(alone[slot.name], whole[slot.name]), slot.name
