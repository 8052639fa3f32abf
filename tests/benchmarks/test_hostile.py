"""Every reader and verb stands in the benchmark of hostile files; a few mutants are harmless."""

import pytest

from benchmarks.hostile import registry, verbs, worker
from benchmarks.hostile.__main__ import every_reader, measure
from benchmarks.hostile.readers import Reader
from hannes.core.errors import BadInput


def test_every_reader_is_in_the_benchmark():
    covered = {name for reader in every_reader() for name in reader.covers}
    assert not registry.missing(covered)
    assert registry.missing(covered - {"hannes.dataset.read:read"}) == ["hannes.dataset.read:read"]
    opened = {name for name in registry.endings() if name not in registry.ALIKE}
    assert opened <= {reader.ending for reader in every_reader()}


def test_every_verb_is_in_the_benchmark():
    assert set(verbs.VERBS) == registry.verbs()


def test_a_few_mutants_and_all_bombs_are_harmless():
    rows, bounds = measure(True, ("readers", "bombs"))
    wrong = [row for row in rows if row["wrong"]]
    assert not wrong
    assert [row["holds"] for row in bounds if "share" not in row["name"]] == [True, True]


@pytest.mark.parametrize(
    ("use", "said"),
    [
        (lambda path: 1 / 0, "ZeroDivisionError"),
        (lambda path: (path.parent / "new").touch(), "changed the folder"),
        (lambda path: exec((path.parent / "canary.py").read_text()), "ran Python"),
        (lambda path: bytearray(200 << 20), "MiB for 3 bytes"),
        (lambda path: __import__("os")._exit(3), "killed it"),
    ],
)
def test_what_is_wrong_is_seen(tmp_path, use, said):
    calls = []

    def after_the_first(path):
        calls.append(path)
        if len(calls) > 1:
            use(path)

    sound = Reader("bad", ".txt", lambda: b"a,b", lambda data, rng: data, after_the_first, ())
    ends = worker.run(sound, range(1), worker.furnished(tmp_path))
    assert len(ends.faults) == 1 and said in ends.faults[0][1]


def test_what_was_done_is_not_done_again(tmp_path):
    def refuse(path):
        raise BadInput("no")

    folder = worker.furnished(tmp_path)
    sound = Reader("once", ".txt", lambda: b"a", lambda data, rng: data, lambda path: None, ())
    first = worker.Ledger(tmp_path / "done.jsonl").run(sound, range(3), folder)
    other = Reader("once", ".txt", sound.seed, sound.mutate, refuse, ())
    again = worker.Ledger(tmp_path / "done.jsonl").run(other, range(3), folder)
    assert (first.read, again.read, again.refused) == (3, 3, 0)
