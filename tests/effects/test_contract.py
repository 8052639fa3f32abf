"""Every effect of the package has what CONTRIBUTING asks: tests, a second formulation, texts."""

import ast
import importlib
import re
from pathlib import Path

import pytest
from catalogued import CATALOGUE

from benchmarks.naming_study import frozen
from benchmarks.truth import effects as truth
from hannes.core.kernels.jit import plain
from hannes.identification.confusability import confusable, text

HERE = Path(__file__).parent
TRUTH = Path(truth.__file__).parent
KERNELS = {
    name: Path(plain(e.terms[0].kernel).__code__.co_filename) for name, e in CATALOGUE.items()
}


def functions_of(file):
    return [
        n.name for n in ast.parse(file.read_text("utf-8")).body if isinstance(n, ast.FunctionDef)
    ]


@pytest.mark.parametrize("name", CATALOGUE)
def test_an_effect_is_tested_in_a_file_of_its_name(name):
    file = HERE / f"test_{name}.py"
    assert file.exists(), (
        f"write {file.relative_to(HERE.parents[1])}: see docs/how-to/add-an-effect.md"
    )
    found = functions_of(file)
    assert "test_equation" in found and any(each.startswith("test_signature") for each in found)
    assert f'check_equations("{name}"' in re.sub(r"\(\s+", "(", file.read_text("utf-8"))
    assert f'runs("{name}", "' in file.read_text("utf-8")


@pytest.mark.parametrize("name", CATALOGUE)
def test_an_effect_stands_in_a_file_of_its_name_and_is_formulated_a_second_time(name):
    assert KERNELS[name].stem == name
    second = importlib.import_module(f"benchmarks.truth.effects.{name}")
    declared = {each.name: each for each in CATALOGUE[name].parameters}
    assert second.SIZES.keys() == declared.keys()
    for own, size in second.SIZES.items():
        each = declared[own]
        assert each.unit == size.unit
        assert each.bounds[0] <= size.low and size.high <= each.bounds[1]
        assert (each.off is not None) is size.amplitude
        assert each.value == size.default


def test_no_file_is_left_of_an_effect_that_is_gone():
    named = {path.stem.removeprefix("test_") for path in HERE.glob("test_*.py")}
    named -= {"contract", "generic"}
    assert named == set(CATALOGUE)
    assert {path.stem for path in TRUTH.glob("[a-z]*.py")} == {
        each.__name__.rpartition(".")[2] for each in (*truth.CATALOGUE, *truth.OUTSIDE)
    }


@pytest.mark.parametrize("name", CATALOGUE)
def test_the_smallest_size_that_can_be_detected_is_known(name):
    """A new effect may wait for that until the next release; then it is named here."""
    file = frozen.measured(name)
    if file is None:
        pytest.skip(f"not yet measured: python -m benchmarks.oracle --effect {name}")
    own = {each.full_name(p.name): p for each in [CATALOGUE[name]] for p in each.amplitudes}
    for protocol in ("poor", "rich"):
        known = frozen.smallest(protocol, file)
        assert own.keys() <= known.keys()
        for amplitude, parameter in own.items():
            sizes = [each.u for each in known[amplitude] if each.u is not None]
            assert all(0.0 < u <= parameter.bounds[1] for u in sizes)


@pytest.mark.parametrize("name", CATALOGUE)
def test_what_it_is_easily_confused_with_is_known(name):
    if not confusable(name):
        assert "not yet measured" in text(name)
        pytest.skip("not yet measured: python -m benchmarks.confusability")
    assert "easily confused with" in text(name)
    assert {other for near in confusable(name).values() for other in near} <= set(CATALOGUE)


@pytest.mark.parametrize("effect", CATALOGUE.values(), ids=CATALOGUE)
def test_texts_fit_a_terminal(effect):
    assert max(map(len, str(effect).splitlines())) <= 78
    assert re.search(r"\(1[4-9]\d\d\)|\(20\d\d\)|paper", effect.source)
