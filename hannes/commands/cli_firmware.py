"""The command that moves a model onto the hand: one C file for a board's firmware."""

import argparse
from collections.abc import Callable

from hannes.commands.cli_output import add_force, add_json, print_json

EXAMPLES = {
    "export-c": """\
hannes train results/large.h5 --trees 16 --leaf 40 --out small-model.h5    for a small board
hannes export-c small-model.h5 --out recogniser.c
cc -O2 -ffp-contract=off -DHANNES_SELF_TEST recogniser.c -lm && ./a.out""",
}


def add(command: Callable[..., argparse.ArgumentParser]) -> None:
    """Add the command; `command(name, call, description)` makes its parser."""
    export = command("export-c", _export_c, "write a model as one C file for a board's firmware")
    export.add_argument("model", help="a model made by `hannes train`")
    export.add_argument("--out", required=True, metavar="FILE.c", help="the C file")
    add_force(export)
    add_json(export)


def _export_c(chosen: argparse.Namespace) -> None:
    from hannes.bench.export_c import FLAGS, export_c
    from hannes.core.errors import BadInput
    from hannes.core.io import atomic_files
    from hannes.core.io.outputs import reserved
    from hannes.recognition import model_file

    if not chosen.out.lower().endswith(".c"):
        raise BadInput(f"--out {chosen.out}: expected a file named .c")
    with reserved("export-c", [chosen.out], [chosen.model], force=chosen.force):
        made = export_c(model_file.read(chosen.model))
        atomic_files.write_bytes(chosen.out, made.text.encode())
    if chosen.json:
        sizes = {"memory_bytes": made.memory_bytes, "table_bytes": made.table_bytes}
        print_json({"out": chosen.out, **sizes, "trees": made.trees, "nodes": made.nodes})
        return
    print(f"wrote {chosen.out}")
    print(f"  memory  {made.memory_bytes} bytes, fixed; nothing is allocated")
    print(f"  tables  {made.table_bytes} bytes: {made.trees} trees of {made.nodes} nodes in all")
    print(f"next: cc {FLAGS} -DHANNES_SELF_TEST {chosen.out} -lm && ./a.out")
