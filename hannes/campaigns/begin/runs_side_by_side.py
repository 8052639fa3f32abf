"""Whether columns of one file are several runs: structures, groups or sheets of the same fields."""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

from hannes.campaigns.begin.channel_words import plain, words_of
from hannes.campaigns.begin.column_guess import LABELS, Guess, Seen, guesses
from hannes.campaigns.foreign.side_by_side import STAR, in_order

FEWEST = 2  # fields that several runs share
SHOWN = 6  # names of runs, as they are listed
# Words of what is several in one machine: what bears them was measured at the same time.
PARTS = (
    *("joint", "motor", "finger", "axis", "servo", "thumb", "index", "middle", "ring", "little"),
    *("left", "right", "channel", "ch", "signal", "signals", "sensor", "topic", "cell", "state"),
    *("gelenk", "achse", "kanal", "links", "rechts", "doigt", "axe", "dito", "giunto", "dedo"),
)
RUNS = (
    *LABELS,
    "runs",
    "trials",
    "reps",
    "repeats",
    "episodes",
    "grasps",
    "demo",
    "test",
    "exp",
    "subject",
)


@dataclass(frozen=True)
class Alike:
    """Columns with the same fields: members by template (`runs/*/time`) and name of the run."""

    fields: Mapping[str, Mapping[str, str]]
    kind: str
    root: str

    @property
    def runs(self) -> list[str]:
        """What stands for the star."""
        return list(next(iter(self.fields.values())))


@dataclass(frozen=True)
class Grouped:
    """Columns of which those of several runs are one each, with a star; what is said and asked."""

    columns: list[Seen]
    said: list[str]
    asked: list[str]


def grouped(seen: Sequence[Seen], known: Sequence[str]) -> Grouped:
    """Columns of runs as one; innermost first, so runs within runs count as such.

    known: channels of the plant. Only what is evident is taken: each has a clock of its own, and
    a number or a word of runs; else it is asked.
    """
    columns, said, asked = list(seen), [], []
    while family := next((each for each in _families(columns) if _evident(each, columns)), None):
        columns, lost = _as_one(columns, family)
        said.append(f"a run for each of {_listed(family.runs)}: {_listed(list(family.fields))}")
        if lost:
            said.append(f"not used, for not every run has it: {_listed(lost)}")
    for family in _families(columns):
        if len({g.channel for g in _guesses(family, columns, known)} - {"time"}) >= FEWEST:
            template = next(iter(family.fields))
            asked.append(
                f"are {_listed(family.runs)} runs of one machine? then write each column with a "
                f'star, as "{template}"; else choose one'
            )
            break
    return Grouped(columns, said, asked)


def _families(columns: Sequence[Seen]) -> list[Alike]:
    """Columns of which the same fields recur, the deepest first."""
    found: dict[tuple[str, str], dict[str, dict[str, str]]] = {}
    for each in columns:
        if isinstance(each.column, str):
            for kind, root, run, template in _places(each.column):
                found.setdefault((kind, root), {}).setdefault(run, {})[template] = each.column
    families = []
    for (kind, root), runs in sorted(found.items(), key=lambda pair: -pair[0][1].count("/")):
        common = [t for t in next(iter(runs.values())) if all(t in own for own in runs.values())]
        if len(runs) > 1 and len(common) >= FEWEST:
            fields = {
                t: {run: runs[run][t] for run in sorted(runs, key=lambda run: in_order((run,)))}
                for t in common
            }
            families.append(Alike(fields, kind, root))
    return families


def _places(name: str) -> Iterator[tuple[str, str, str, str]]:
    """Where a name may differ from run to run: kind, root, name of the run, template."""
    parts = name.split("/")
    for k, part in enumerate(parts):
        before, after = parts[:k], parts[k + 1 :]
        if STAR in part:
            continue
        template = "/".join([*before, STAR, *after])
        if after:
            yield "part", "/".join(before), part, template
        if part.isdecimal() and k:
            yield "number", parts[0], part, template  # a structure of arrays, number last
        elif not after:
            for found in re.finditer(r"\d+", part):
                own = f"{part[: found.start()]}{STAR}{part[found.end() :]}"
                yield "digits", "/".join(before), found[0], "/".join([*before, own])


def _evident(family: Alike, columns: Sequence[Seen]) -> bool:
    """Whether they are surely runs: numbered, or named so, and each on a clock of its own."""
    clocks = [g.column for g in _guesses(family, columns, ()) if g.channel == "time"]
    if not clocks or _at_once(family, columns, str(clocks[0])):
        return False
    numbers = [re.sub(r"\d+", "", run) for run in family.runs]
    counted = len(set(numbers)) == 1 and all(re.search(r"\d", run) for run in family.runs)
    each = [_words(run) for run in numbers]
    words = set.union(*each) | _words(family.root) | _before_the_number(family)
    if all(own & set(RUNS) for own in each) or (counted and words & set(RUNS)):
        return True
    # Counting alone is no evidence: j1, m1 or hand1 may be parts or machines.
    letters = any(map(bool, each)) or _before_the_number(family)
    return counted and not letters and not {w.removesuffix("s") for w in words} & set(PARTS)


def _before_the_number(family: Alike) -> set[str]:
    """The word before a number inside the names of columns, where all fields share it."""
    if family.kind != "digits":
        return set()
    before = [t.rpartition("/")[2].partition(STAR)[0] for t in family.fields]
    last = {(["", *filter(None, words_of(each))])[-1] for each in before}
    return {plain(word) for word in last if word} if len(last) == 1 else set()


def _at_once(family: Alike, columns: Sequence[Seen], clock: str) -> bool:
    """Whether absolute clocks overlap: then all was measured at the same time."""
    values = {str(each.column): each.values for each in columns}
    members = next(own for own in family.fields.values() if clock in own.values())
    known = [values[name] for name in members.values()]
    spans = sorted((float(x.min()), float(x.max())) for x in known if x is not None and x.size)
    if not spans or spans[0][0] <= max(end - start for start, end in spans):
        return False  # counted from the start of each
    return any(start < end for (_, end), (start, _) in pairwise(spans))


def _words(name: str) -> set[str]:
    return {plain(word) for part in name.split("/") for word in words_of(part)}


def _guesses(family: Alike, columns: Sequence[Seen], known: Sequence[str]) -> list[Guess]:
    first = {next(iter(members.values())): t for t, members in family.fields.items()}
    return guesses(
        [_named(each, first[str(each.column)]) for each in columns if str(each.column) in first],
        known,
    )


def _named(seen: Seen, template: str) -> Seen:
    """A column under the name that it has without the number of its run."""
    if seen.name != seen.column or STAR not in template.rpartition("/")[2]:
        return seen
    own = template.removesuffix(f"/{STAR}")
    return replace(seen, name=re.sub(r"[ _.-]*[*][ _.-]*", "_", own).strip("_"))


def _as_one(columns: Sequence[Seen], family: Alike) -> tuple[list[Seen], list[str]]:
    """The columns with those of the runs as one, and those that only some runs have."""
    template = {name: t for t, members in family.fields.items() for name in members.values()}
    made: list[Seen] = []
    lost: list[str] = []
    for each in columns:
        own = template.get(str(each.column))
        if own is None and _is_of(str(each.column), family):
            lost.append(str(each.column))
        elif own is None:
            made.append(each)
        elif all(kept.column != own for kept in made):
            made.append(replace(_named(each, own), column=own))
    return made, lost


def _is_of(name: str, family: Alike) -> bool:
    """Whether a column belongs to one of the runs."""
    places = [(kind, root, run) for kind, root, run, _ in _places(name)]
    return any((family.kind, family.root, run) in places for run in family.runs)


def _listed(names: Sequence[str]) -> str:
    more = f" and {len(names) - SHOWN} more" if len(names) > SHOWN else ""
    return ", ".join(names[:SHOWN]) + more
