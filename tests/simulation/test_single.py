"""Functions of a model as our own compiler makes them, one grasp at a time."""

import math

import numpy as np
import pytest
from llvmlite import ir

from hannes.core.effect import Effect, Term
from hannes.core.kernels.jit import kernel
from hannes.core.parameter import Parameter
from hannes.simulation.compiler.autodiff.values import tree
from hannes.simulation.compiler.lanes import handed, machine
from hannes.simulation.compiler.lanes.emitter import Emitter
from hannes.simulation.compiler.lanes.single import OF_MODEL, OF_OUTPUTS, Entry
from hannes.simulation.compiler.lanes.values import NotInLanes, Text
from hannes.simulation.hand.hand import Hand
from tests.assembled_spring import spring
from tools.compile_ahead import catalogue

pytestmark = pytest.mark.usefixtures("compiling")


def first_above(times, y, p, memory):
    """Returns from loops within loops, and arrays that a condition chooses."""
    chosen = times if p[0] > 0.0 else y
    for k in range(chosen.size):
        if chosen[k] < 0.0:
            memory[0] = k
            return -1
        place = 0
        while True:
            if chosen[k] * place > p[1]:
                memory[1] = chosen[k] * place
                return 10 * k + place
            place += 1
            if place > 4:
                break
        memory[2] += place
    return 1000


def cumulated(times, y, p, memory):
    """Room of its own in each turn, parts of arrays, and a number that begins whole."""
    total = 0
    for k in range(times.size):
        held = np.zeros(3)
        held[:2] = y[k]
        held[2] += times[k]
        total = total + math.sqrt(abs(held[0] * held[1] + held[2]))
        memory[:2] = total
    memory[2] = row_sum(p[1:])
    return times.size


def row_sum(row):
    found = 0.0
    for i in range(row.size):
        found += row[i]
    return found


def compiled(function):
    """Machine code of a function of arrays, as Python calls it."""
    made = Emitter(ir.Module(), 1, {})
    handed.write(made, Text(tree(function), function.__globals__), {})
    loaded = machine.Loaded(machine._compiled(made.module, lanes=False))
    return handed.callable_from(loaded, function)


GIVEN = [
    (np.array([0.1, 0.2, 3.0]), np.array([1.0, -2.0, 5.0]), np.array([switch, most, 0.5]))
    for switch in (1.0, -1.0)
    for most in (0.3, 7.0, 1e3)
]


@pytest.mark.parametrize("function", [first_above, cumulated])
def test_it_is_what_python_does(function):
    run = compiled(function)
    for given in GIVEN:
        expected, found = np.zeros(3), np.zeros(3)
        assert run(*given, found) == function(*given, expected)
        assert found.tobytes() == expected.tobytes()


def test_arrays_that_are_not_as_expected_are_copied_or_refused():
    run, (times, y, p) = compiled(cumulated), GIVEN[0]
    expected = np.zeros(3)
    cumulated(times, y, p, expected)
    every_other, held = np.zeros(6), np.zeros(6)
    every_other[::2] = y
    run(times.astype(">f8"), every_other[::2], p.astype(object), held[::2])
    assert held[::2].tobytes() == expected.tobytes() and not held[1::2].any()
    for other in (None, [1.0], 3.0, np.zeros((1, 3))):
        with pytest.raises(TypeError, match="expected an array of 1 dim"):
            run(times, y, p, other)


@kernel
def by_error_function(place, share):
    """Numba knows this function, our compiler does not."""
    return share * math.erf(place)


OWN = Effect(
    "by_error_function", "It pushes.", "push += share place", "a test",
    (Parameter("share", 0.0, "1", (0.0, 10.0), "share", off=0.0),),
    (Term(by_error_function, ("push",)),),
)  # fmt: skip
AT = (0.0, np.array([1.0, 100.0]))
HELD = np.array([[0.0, 1.0], [0.0, 2.0]]), np.zeros(1)


def test_what_is_not_known_here_is_left_to_numba(tmp_path, monkeypatch):
    monkeypatch.setenv("HANNES_CACHE", str(tmp_path))
    model = spring(OWN)
    given = *AT, np.array([3.0, 2.0, 0.5]), *HELD
    found = model.fast.rates(*given)
    assert model.fast.rates.run is model.fast.rates.by_numba
    assert found.tolist() == [100.0, 0.5 * math.erf(1.0) - 3.0 - math.tanh(200.0)]
    assert model.is_warm() and not model.is_warm("grasps")


def test_errors_of_python_are_raised():
    rates = spring().fast.rates
    assert isinstance(rates, Entry)
    with pytest.raises(TypeError):
        rates("now", AT[1], np.array([3.0, 2.0]), *HELD)
    with pytest.raises(TypeError):
        rates(*AT, np.array([3.0, 2.0]), None, HELD[1])


def by_name(times, y, p, memory):
    held = np.zeros(3, dtype=np.int64)
    held[0] = p[0]
    return held[0]


def of_many(times, y, p, memory):
    held = np.zeros(1_000_000)
    return held[0]


def one_way(times, y, p, memory):
    """An array that one way alone has, and looks at again."""
    total = 0.0
    for k in range(times.size):
        if p[0] > 0.0:
            row = y[1:]
        total += times[k]
        if p[0] > 0.0:
            total += row[0]
    memory[0] = total
    return 1


@pytest.mark.parametrize("function", [by_name, of_many])
def test_what_would_be_another_number_or_too_large_is_refused(function):
    with pytest.raises(NotInLanes):
        compiled(function)


def test_an_array_of_one_way_is_known_on_that_way():
    run = compiled(one_way)
    for given in GIVEN:
        expected, found = np.zeros(3), np.zeros(3)
        assert run(*given, found) == one_way(*given, expected)
        assert found.tobytes() == expected.tobytes()


def test_what_is_as_expected_is_never_copied():
    """One that is not must not undo what another thread writes to the others."""
    run, (times, y, p) = compiled(cumulated), GIVEN[0]
    p.setflags(write=False)
    found = np.zeros(3)
    run(times[::-1], y, p, found)
    assert found.any()


@pytest.mark.parametrize("hand", [Hand, catalogue])
def test_nothing_of_the_hand_is_left_to_numba(hand):
    entry = hand().compiled().fast.grasps
    assert isinstance(entry, Entry)
    names = {each.name for each in entry.single.written().functions if not each.is_declaration}
    assert names >= {
        name for each in (OF_MODEL, OF_OUTPUTS) for own in each.values() for name in own
    }
