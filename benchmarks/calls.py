"""Calls in numba's machine code of grasps: how many words each hands on, where references count.

Read from what LLVM made of `grasps`, after it has made functions into their callers, and from the
disassembly. Numba hands an array on as seven words or more; copying them from stack to stack took
half of a grasp on some processors. Left out is what Python calls: it calls
`grasp` once for each.
"""

import re
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from benchmarks.harness import Row, aligned, main, must_show

MOST = 16  # words
ENTRIES = ("grasps", "each_grasp")  # call `grasp` once for each, in which all else goes on
# Functions that unpack what Python or C gives, and those of numba that count references.
OUTSIDE = ("_ZN7cpython", "cfunc.", "NRT_")
HANDS: dict[str, tuple[str, ...]] = {
    "no effect": (),
    "three effects": ("leader_slack", "gear_load", "wire_compliance"),
    "dense differences": ("floating_object",),
}


@dataclass(frozen=True)
class Call:
    """One call in machine code: from where to where, with how many words."""

    caller: str
    callee: str
    words: int

    @property
    def counts_references(self) -> bool:
        """Whether it counts references to memory, or asks for memory."""
        return self.callee.startswith("NRT_")


def calls(dispatcher: Any) -> list[Call]:
    """Calls within the functions behind a dispatcher; those for each grasp alone are left out."""
    import llvmlite.binding as llvm

    module = llvm.parse_assembly(_made(dispatcher).get_llvm_str())
    found = [each for function in module.functions for each in _of(function)]
    return [each for each in found if each.caller not in ENTRIES] or found


def _made(dispatcher: Any) -> Any:
    """What LLVM made of the one signature that was called."""
    (overload,) = dispatcher.overloads.values()
    return overload.library


def _of(function: Any) -> Iterator[Call]:
    if function.name.startswith(OUTSIDE):
        return
    for block in function.blocks:
        for instruction in block.instructions:
            if instruction.opcode in ("call", "invoke"):
                *given, called = instruction.operands
                if called.name and not called.name.startswith("llvm."):
                    yield Call(_plain(function.name), _plain(called.name), len(given))


def _plain(name: str) -> str:
    """Name of a function as it is written, of numba's."""
    place, parts = len("_ZN"), list[str]()
    while name.startswith("_ZN") and (size := re.match(r"\d+", name[place:])):
        place += size.end() + int(size[0])
        parts.append(name[place - int(size[0]) : place])
    return re.sub(r"(_at)?$", "", parts[-1].partition("B")[0]) if parts else name


def pushes(dispatcher: Any) -> int:
    """Longest run of `push` in the disassembly of the same: words that go by the stack."""
    longest = run = 0
    inside = False
    for line in _made(dispatcher).get_asm_str().splitlines():
        if label := re.match(r"(_ZN\S+|cfunc\.\S+|NRT_\w+):", line):
            inside = not label[1].startswith(OUTSIDE) and _plain(label[1]) not in ENTRIES
        elif inside and line.startswith("\t") and not line.startswith("\t."):
            run = run + 1 if line.startswith("\tpush") else 0
            longest = max(longest, run)
    return longest


def compiled(effects: tuple[str, ...]) -> Any:
    """The entry `grasps` of a hand, compiled anew by numba, as where its text is refused else."""
    import os

    from hannes import Hand, load_experiment, simulate_many

    with tempfile.TemporaryDirectory() as folder:
        os.environ["HANNES_CACHE"] = folder
        hand, experiment = Hand(effects), load_experiment("dynamometer")[0].experiment
        fast = hand.compiled(hand.effects).fast
        fast.grasps = fast.grasps.by_numba
        run = simulate_many([(hand, experiment)], rtol=1e-2, effects=hand.effects, workers=1)
        for grasp in run:
            grasp.require()
        return fast.grasps


def measure(quick: bool) -> tuple[list[Row], list[Row]]:
    """A row for each hand."""
    rows, most, counted = list[Row](), 0, 0
    for name, effects in list(HANDS.items())[: 1 if quick else None]:
        print(f"calls: compiling {name}", file=sys.stderr, flush=True)
        dispatcher = compiled(effects)
        found = calls(dispatcher)
        widest = max(found, key=lambda call: call.words)
        references = sum(call.counts_references for call in found)
        rows.append(
            {
                "hand": name,
                "calls": len(found),
                "most_words": widest.words,
                "from": widest.caller,
                "to": widest.callee,
                "pushes_in_a_row": pushes(dispatcher),
                "reference_counts": references,
            }
        )
        most, counted = max(most, widest.words), counted + references
    return aligned(rows), [
        must_show("most words that a call hands on", most, MOST, most <= MOST),
        must_show("calls that count references, inside grasps", counted, 0, counted == 0),
    ]


if __name__ == "__main__":
    main(__doc__, "calls", measure)
