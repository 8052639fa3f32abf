"""Every verb with mutants of what it reads, through the command line: no exit status but 0, 2, 3.

Verbs that read no file of a stranger say so. Those that fit or simulate for long are given files
of another kind, which they must refuse: their own are given to their readers.
"""

import tempfile
from collections.abc import Callable
from pathlib import Path

from benchmarks.hostile.readers import Reader, of_data
from benchmarks.hostile.tomls import of_settings
from hannes.core.errors import BadInput

# Verb -> (reader of which it gets mutants, words of the command; {} stands for the mutant, OUT for
# a folder that is thrown away). None: it reads no file of a stranger.
VERBS: dict[str, list[tuple[str, str]] | None] = {
    "run": [("board", "run {} --out OUT/r")],
    "experiments": None,
    "effects": [("hand", "effects {}")],
    "hand": [("hand", "hand {}"), ("hand", "hand {} --values")],
    "reproduce": None,
    "calibrate": [("evaluation", "calibrate {} --out OUT/c")],
    "diagnose": [("evaluation", "diagnose {} --out OUT/d")],
    "compare": [("evaluation", "compare {} --out OUT/p")],
    "convert": [
        ("text", "convert {} --mapping text.mapping.toml --out OUT/x.h5"),
        ("mapping", "convert plain.csv --mapping {} --out OUT/x.csv"),
    ],
    "begin": [("unknown log", "begin {} --out OUT/b")],
    "check": [
        ("recording", "check {}"),
        ("HDF5 recording", "check {} --json"),
        ("campaign", "check {}"),
        ("finger log", "check {} --plant finger"),
    ],
    "dataset": [("hand", "dataset {} --out OUT/s.h5 --workers 1")],
    "train": [("data set", "train {} --out OUT/m.h5 --trees 2")],
    "evaluate": [("model", "evaluate {} evaluation.toml --out OUT/e")],
    "board": [("hand", "board {} --seconds 0.01")],
    "record": [("raw log", "record --recover {} --out OUT/r.h5")],
    "port": None,
    "panel": [
        ("hand", "panel /dev/no-such-port --beside {}"),
        ("model", "panel /dev/no-such-port --model {}"),
    ],
    "export-c": [("model", "export-c {} --out OUT/m.c")],
    "view": [("recording", "view {} --out OUT/v.html")],
    "fmu": [("evaluation", "fmu {} --out OUT/x.fmu")],
    "export": [
        ("recording", "export {} --out OUT/x.mat"),
        ("HDF5 recording", "export {} --out OUT/x.mat"),
    ],
    "completion": None,
    "trust": [("consent", "trust {} --forget")],
}


def every_verb() -> list[Reader]:
    """The verbs, each as a reader of mutants."""
    known = {each.name: each for each in (*of_data(), *of_settings())}
    return [
        Reader(
            words, known[name].ending, known[name].seed, known[name].mutate, _use(words), (), False
        )
        for given in VERBS.values()
        for name, words in given or ()
    ]


def _use(words: str) -> Callable[[Path], None]:
    def use(path: Path) -> None:
        from hannes.commands.cli import main

        with tempfile.TemporaryDirectory() as out:
            texts = words.replace("{}", str(path)).replace("OUT", out).split()
            status = main(texts)
        if status in (2, 3):
            raise BadInput(f"exit {status}")
        if status:
            raise RuntimeError(f"exit {status}")

    return use
