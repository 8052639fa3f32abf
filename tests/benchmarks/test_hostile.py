"""Every reader and verb stands in the benchmark of hostile files; a few mutants are harmless."""

import signal
import time

import pytest

from benchmarks.hostile import registry, verbs, worker
from benchmarks.hostile.__main__ import every_reader, measure
from benchmarks.hostile.readers import Reader
from hannes.core.errors import BadInput


@pytest.fixture(scope="module")
def covered(tmp_path_factory):
    """What runs while all entries read their sound files."""
    folder = worker.furnished(tmp_path_factory.mktemp("covered"))
    return registry.covered(every_reader(), folder)


def test_every_reader_is_in_the_benchmark(covered):
    assert not registry.missing(covered)
    plain_table = "hannes.campaigns.foreign.plain_table:plain_table"
    assert registry.missing(covered - {plain_table}) == [plain_table]
    opened = {name for name in registry.endings() if name not in registry.ALIKE}
    assert opened <= {reader.ending for reader in every_reader()}


def test_excuses_are_of_what_there_is():
    known = list(registry.readers())
    for name in registry.NO_READERS:
        inside = (name + ":", name + ".")
        assert any(each == name or each.startswith(inside) for each in known), name


def test_a_reader_is_known_by_what_it_opens_whatever_its_name(tmp_path, monkeypatch):
    (tmp_path / "new.py").write_text("class A:\n    def table(self, p):\n        p.open()\n")
    monkeypatch.setattr(registry, "PACKAGE", tmp_path)
    assert list(registry.readers()) == [f"{tmp_path.name}.new:A.table"]


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

    sound = Reader("bad", ".txt", lambda: b"a,b", lambda data, rng: data, after_the_first)
    ends = worker.run(sound, range(1), worker.furnished(tmp_path))
    assert len(ends.faults) == 1 and said in ends.faults[0][1]


def test_what_was_done_is_not_done_again(tmp_path):
    def refuse(path):
        raise BadInput("no")

    folder = worker.furnished(tmp_path)
    sound = Reader("once", ".txt", lambda: b"a", lambda data, rng: data, lambda path: None)
    first = worker.Ledger(tmp_path / "done.jsonl").run(sound, range(3), folder)
    other = Reader("once", ".txt", sound.seed, sound.mutate, refuse)
    again = worker.Ledger(tmp_path / "done.jsonl").run(other, range(3), folder)
    assert (first.read, again.read, again.refused) == (3, 3, 0)


@pytest.mark.parametrize(
    ("use", "why"),
    [
        (lambda path: time.sleep(0.4), []),  # as on a machine with other work
        (lambda path: spin(), ["hung"]),  # as in a library that hears no signal
    ],
)
def test_only_what_computes_counts_as_hung(tmp_path, monkeypatch, use, why):
    monkeypatch.setattr(worker, "LOOK", 0.05)
    monkeypatch.setattr(worker, "BEYOND", 0.15)
    calls = []

    def after_the_first(path):
        calls.append(path)
        if len(calls) > 1:
            use(path)

    slow = Reader("slow", ".txt", lambda: b"a", lambda data, rng: data, after_the_first, seconds=0)
    ends = worker.run(slow, range(1), worker.furnished(tmp_path))
    assert [each for _, each in ends.faults] == why and ends.count == 1


def spin():
    signal.signal(signal.SIGPROF, signal.SIG_IGN)
    while True:
        pass


def test_a_sound_file_that_is_refused_is_said(tmp_path):
    def refuse(path):
        raise BadInput("no such unit")

    bad = Reader("bad", ".txt", lambda: b"a", lambda data, rng: data, refuse)
    ends = worker.run(bad, range(3), worker.furnished(tmp_path))
    assert ends.faults == [(k, "the sound file: no such unit") for k in range(3)]
