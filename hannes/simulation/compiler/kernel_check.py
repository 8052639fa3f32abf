"""What a run would refuse of an effect, found in a moment: without the model around it compiled."""

from typing import Any

from hannes.core.effect import Effect, Term
from hannes.core.errors import BadInput
from hannes.core.kernels import jit
from hannes.simulation.compiler.assemble import Equations
from hannes.simulation.compiler.expansion import Layouts
from hannes.simulation.compiler.kernel_error import blamed
from hannes.simulation.compiler.kernel_trial import ARRAY, fault

_NUMBERS = ("float", "int", "uint", "bool")


def check_kernels(equations: Equations, effect: Effect) -> None:
    """Compile each kernel of an effect alone; BadInput in one line where that or a run fails.

    The effect must be one that `equations.accepts`.
    """
    layouts = Layouts(
        equations.parameters, equations.states, equations.channels, equations.outputs, (effect,)
    )
    for term in effect.terms if jit.compiles() else ():
        if why := _refused(layouts, effect, term):
            code = jit.plain(term.kernel).__code__
            raise BadInput(f"{code.co_filename}: kernel {code.co_name} {why}")


def _refused(layouts: Layouts, effect: Effect, term: Term) -> str:
    """Why a kernel cannot be called where its term belongs, or an empty string."""
    function = jit.plain(term.kernel)
    if function is term.kernel:
        return "is a plain function: mark it @kernel"
    axis = layouts.c.slot(term.writes[0]).axis
    given = [layouts.argument(name, effect, axis) for name in term.arguments]
    types = ["float64[::1]" if ARRAY.search(each) else "float64" for each in given]
    compiled = jit.kernel(function)
    try:
        compiled.compile(f"({', '.join(types)},)")
    except Exception as error:  # numba's errors have no common class
        raise blamed(error) or error from None
    (made,) = compiled.overloads.values()
    wanted = (*term.writes, *term.states)
    return _miscounted(made.signature.return_type, wanted) or fault(compiled, effect, term, given)


def _miscounted(returned: Any, wanted: tuple[str, ...]) -> str:
    """What is wrong with what a kernel returns, one number for each of `wanted`; else ''."""
    values = list(getattr(returned, "types", [returned]))
    if len(values) != len(wanted):
        return f"returns {len(values)} values: expected {len(wanted)}, for {', '.join(wanted)}"
    for each, name in zip(values, wanted, strict=True):
        if not str(each).startswith(_NUMBERS):
            return f"returns {each} for {name}: expected a number"
    return ""
