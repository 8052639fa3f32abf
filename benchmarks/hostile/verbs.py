"""Every verb with mutants of what it reads, through the command line: no exit status but 0, 2, 3.

Verbs that read no file of a stranger say so. Those that fit are given campaigns of a plant that is
quick, with recordings that are too few for a fit.
"""

import io
import tempfile
from collections.abc import Callable, Iterator
from contextlib import redirect_stderr
from pathlib import Path

from benchmarks.hostile import corpus
from benchmarks.hostile.readers import Reader, of_data
from benchmarks.hostile.toml_seeds import ALONE, HAND
from benchmarks.hostile.tomls import of_settings
from hannes.core.errors import BadInput

SECONDS = 120.0  # of processor time of one command: it may compile a model, a minute each
ROOT = Path(__file__).parents[2]
PORT = "/dev/no-such-port"

# Verb -> (reader of which it gets mutants, words of the command; {} stands for the mutant, OUT for
# a folder that is thrown away). None: it reads no file of a stranger.
VERBS: dict[str, list[tuple[str, str]] | None] = {
    "run": [("experiment", "run {} --out OUT/r")],
    "experiments": None,
    "effects": [("own effect", "effects {}:EFFECT")],
    "hand": [
        ("hand", "hand {}"),
        ("hand", "hand {} --values"),
        ("bare hand", "hand {} --mjcf"),
        ("hand", "hand {} --schematic"),
    ],
    "reproduce": None,
    "calibrate": [("axis campaign", "calibrate {} --out OUT/c")],
    "diagnose": [("axis campaign", "diagnose {} --out OUT/d")],
    "compare": [("campaign", "compare {} --out OUT/p")],
    "convert": [
        ("text", "convert {} --mapping text.mapping.toml --out OUT/x.h5"),
        ("mapping", "convert plain.csv --mapping {} --out OUT/x.csv"),
    ],
    "begin": [("unknown log", "begin {} --out OUT/b")],
    "check": [
        ("recording", "check {}"),
        ("HDF5 recording", "check {} --json"),
        ("campaign", "check {}"),
        ("finger log", "check {} --mapping rh56"),
    ],
    "dataset": [
        ("data set's specification", "dataset {} --out OUT/s.h5 --workers 1"),
        ("data set's specification", "dataset {} --out OUT/s.h5 --grasp 1"),
    ],
    "train": [("data set", "train {} --out OUT/m.h5 --trees 2")],
    "evaluate": [
        ("model", "evaluate {} evaluation.toml --out OUT/e"),
        ("evaluation", "evaluate model.h5 {} --out OUT/e"),
        ("HDF5 recording", "evaluate model.h5 {}"),
        ("data set", "evaluate model.h5 evaluation.toml --baselines {}"),
    ],
    "board": [("board", "board {} --seconds 0.01")],
    "record": [
        ("raw log", "record --recover {} --out OUT/r.h5"),
        ("dynamometer", "record --recover grasp.rawlog --dynamometer {} --out OUT/r.h5"),
    ],
    "port": None,
    "live": [("model", f"live {PORT} {{}} --seconds 0.1")],
    "panel": [("board", f"panel {PORT} --beside {{}}"), ("model", f"panel {PORT} --model {{}}")],
    "export-c": [("model", "export-c {} --out OUT/m.c")],
    "view": [("HDF5 recording", "view {} --out OUT/v.html")],
    "fmu": [("one experiment", "fmu {} --out OUT/x.fmu")],
    "export": [
        ("recording", "export {} --out OUT/x.mat"),
        ("HDF5 recording", "export {} --out OUT/x.mcap"),
    ],
    "completion": None,
    "trust": [("consent", "trust {} --forget")],
}


def own_effect() -> Reader:
    """A file of Python with an effect, numbers and texts of which are changed."""
    seed = (ROOT / "examples" / "own_effect" / "grease.py").read_bytes
    return Reader("own effect", ".py", seed, corpus.python, lambda path: None)


def own_settings() -> Iterator[Reader]:
    """An experiment that is one simulation, and a hand without effects."""
    bare = "\n".join(line for line in HAND.splitlines() if "sag" not in line)
    for name, text in (("one experiment", ALONE), ("bare hand", bare)):
        yield Reader(name, ".toml", text.encode, corpus.toml, lambda path: None)


def every_verb() -> list[Reader]:
    """The verbs, each as a reader of mutants."""
    found = (*of_data(), *of_settings(), own_effect(), *own_settings())
    known = {each.name: each for each in found}
    return [_verb(known[name], words) for given in VERBS.values() for name, words in given or ()]


def _verb(reader: Reader, words: str) -> Reader:
    """A verb whose sound file is accepted, unless it goes on to a port that is not there."""
    sound, kept = PORT not in words, (reader.ending, reader.seed, reader.mutate)
    return Reader(words, *kept, _use(words), sound, SECONDS)


def _use(words: str) -> Callable[[Path], None]:
    def use(path: Path) -> None:
        from hannes.commands.cli import main

        with tempfile.TemporaryDirectory() as out:
            texts = words.replace("{}", str(path)).replace("OUT", out).split()
            with redirect_stderr(io.StringIO()) as said:
                status = main(texts)
        last = (said.getvalue().strip().splitlines() or [""])[-1]
        if status in (2, 3):
            raise BadInput(last)
        if status:
            raise RuntimeError(f"exit {status}: {last}")

    return use
