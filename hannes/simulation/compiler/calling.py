"""Long functions of generated text that take the addresses of their arrays.

A call that LLVM does not inline copies seven words for an array from stack to stack, for all of a
model's a hundred and more: on some processors half of a grasp went into that. Such a function is
written twice: as it stands, made into its callers, it hands on addresses; the other has the arrays
of them again, whose sizes are known when the model is assembled (docs/explanation/speed.md).
"""

import ast

# Shapes of what long functions are given, by the name of the argument.
_ROW = ("unknown(STATES)",)
_OF_STAGES = {
    "y": _ROW,
    "dy": _ROW,
    "p": ("unknown(PARAMETERS)",),
    "c": ("CHANNELS",),
    "out": ("OUTPUTS",),
    "needed": ("STATEMENTS",),
    "reference": ("reference.shape[0]", "reference.shape[1]"),
    "memory": ("memory.size",),
}
_OF_STEPS = {
    "y": _ROW,
    "atol": _ROW,
    "clock": ("6",),
    "counts": ("5",),
    "work": ("WORK", "unknown(STATES)"),
    "bounds": ("bounds.size",),
    "times": ("times.size",),
    "ends": ("ends.size",),
    "pieces": ("ends.size", "3", "unknown(STATES)"),
    "rows": ("times.size", "unknown(STATES)"),
}
SHAPES: dict[str, dict[str, tuple[str, ...]]] = {
    **dict.fromkeys(("equations", "sample", "joints", "contact", "press", "inertia"), _OF_STAGES),
    "linearise": dict.fromkeys(("y", "rates", "drift"), _ROW),
    "resolve": {"b": _ROW},
    "factor_border": {
        "border": ("COUNT + 10", "ROWS"),
        "couplings": ("2", "1 + SEEING", "5"),
        "lu": ("ENTRIES",),
    },
    "fill_outputs": {
        **_OF_STAGES,
        "times": ("times.size",),
        "states": ("times.size", "unknown(STATES)"),
        "memories": ("times.size", "memories.shape[1]"),
        "rows": ("times.size", "OUTPUTS"),
    },
    **dict.fromkeys(("first_step", "advance", "advance_tick", "sample_pieces"), _OF_STEPS),
}


def by_address(text: str) -> str:
    """The same text with its long functions called by addresses."""
    lines = text.splitlines()
    for node in reversed(ast.parse(text).body):
        if isinstance(node, ast.FunctionDef) and node.name in SHAPES:
            start = node.lineno - 1 - len(node.decorator_list)
            lines[start : node.body[0].lineno - 1] = _both(node, SHAPES[node.name])
    return "\n".join(lines) + "\n"


def _both(node: ast.FunctionDef, shapes: dict[str, tuple[str, ...]]) -> list[str]:
    """What takes arrays, and the head of what takes addresses, up to the body of `node`."""
    names = [each.arg for each in node.args.args]
    handed, taken, made = [], [], []
    for name in names:
        if name not in shapes:
            handed.append(name)
            taken.append(name)
            continue
        handed.append(f"pointer({name})")
        taken.append(f"{name}_at")
        sizes = []
        for n, size in enumerate(shapes[name]):
            if "." in size:  # known when it is called
                handed.append(size)
                taken.append(f"{name}_{n}")
                size = f"{name}_{n}"
            sizes.append(size)
        made.append(f"    {name} = shaped({name}_at, ({', '.join(sizes)},))")
    return [
        "@inner",
        f"def {node.name}({', '.join(names)}):",
        f"    return {node.name}_at({', '.join(handed)})",
        "",
        "",
        *(f"@{ast.unparse(each)}" for each in node.decorator_list),
        f"def {node.name}_at({', '.join(taken)}):",
        *made,
    ]
