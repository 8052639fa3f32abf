"""From cases to figures; every proportion over all cases of its kind, with its 95 % interval."""

from collections import Counter
from collections.abc import Callable, Sequence
from statistics import NormalDist
from typing import Any

import numpy as np

from benchmarks.harness import Row, interval, must_show
from benchmarks.naming_study.plan import KINDS
from benchmarks.naming_study.probabilities import probabilities
from benchmarks.oracle.discriminant import FALSE_ALARM, POWER

Case = dict[str, Any]
Cases = Sequence[Case]
CLEAR = 2.0  # times the smallest detectable size
RIGHT, WRONG = {"rich": 0.90, "poor": 0.70, "poor, duty": 0.80}, {"rich": 0.02}
POOR_WRONG = 0.03
CLOSING = ("right", "class", "both", "one", "part")  # outcomes: all others close nothing
SECONDS = 60.0  # of a diagnosis of twelve recordings


def share(cases: Cases, *outcomes: str) -> dict[str, Any]:
    """How many of the cases end so, with the interval of the proportion (Wilson)."""
    from scipy.stats import binomtest

    hits = sum(case["outcome"] in outcomes for case in cases)
    found = binomtest(hits, len(cases)).proportion_ci(method="wilson")
    return {
        "value": hits / len(cases),
        "low": float(found.low),
        "high": float(found.high),
        "hits": hits,
        "cases": len(cases),
    }


def at_least(name: str, found: dict[str, Any], bound: float) -> Row:
    """A proportion that must be as high as `bound`."""
    return {**must_show(name, found["value"], bound, found["value"] >= bound), **_beside(found)}


def at_most(name: str, found: dict[str, Any], bound: float) -> Row:
    """A proportion that must be as low as `bound`."""
    return {**must_show(name, found["value"], bound, found["value"] <= bound), **_beside(found)}


def figures(done: Cases) -> tuple[list[Row], list[Row]]:
    """Rows of every kind that has cases, and what must be shown."""
    made = [case for case in done if "outcome" in case]
    found = [_row(kind.name, of(done, kind.name)) for kind in KINDS if of(done, kind.name)]
    parts: tuple[Callable[[Cases], list[Row]], ...] = (
        singles, closures, empties, outsiders, pairs, closing, sizes, assumed_wrong, next_run,
        seconds, probabilities,
    )  # fmt: skip
    every = [row for part in parts for row in part(made)]
    reported = [row for row in every if "holds" not in row]
    return [*found, *reported], [row for row in every if "holds" in row]


def of(cases: Cases, name: str) -> list[Case]:
    """Cases of one kind."""
    return [case for case in cases if case["kind"] == name]


def clear(cases: Cases) -> list[Case]:
    """Cases in which everything hidden is at least twice the smallest detectable."""
    return [c for c in cases if c["times"] is not None and c["times"] >= CLEAR]


def detectable(cases: Cases, least: float = 1.0) -> list[Case]:
    """Cases in which what is hidden is at least the smallest detectable."""
    return [c for c in cases if c["times"] is not None and c["times"] >= least]


def singles(cases: Cases) -> list[Row]:
    """Single hidden effects by protocol: right or class, wrong, size of classes."""
    rows = []
    for protocol, least in RIGHT.items():
        some = clear(of(cases, f"single, {protocol}"))
        if some:
            name = f"single effect at {CLEAR:g} u or more, {protocol}"
            rows.append(at_least(f"{name}: right or class", share(some, "right", "class"), least))
            most = WRONG.get(protocol, POOR_WRONG)
            rows.append(at_most(f"{name}: wrong", share(some, "wrong"), most))
            size = float(np.mean([max(1, len(c["named"])) for c in some]))
            name = f"{name}: mean size of class"
            rows.append(
                must_show(name, size, 1.3, size <= 1.3)
                if protocol == "rich"
                else {"study": name, "value": size}
            )
    return rows


def closures(cases: Cases) -> list[Row]:
    """The paper's own gap."""
    some = of(cases, "closures, closures")
    name = "slack in free closures is named"
    return [at_least(name, share(some, "right"), 1.0)] if some else []


def empties(cases: Cases) -> list[Row]:
    """False alarms over all hands in which nothing is hidden, or nothing that could be named."""
    some = [c for c in cases if c["what"] == "empty" and c["assumed_ratio"] == 1.0]
    hardly = [
        c
        for c in cases
        if c["what"] == "single" and c["times"] is None and c["assumed_ratio"] == 1.0
    ]
    rows = []
    if some:
        rows.append(at_most("nothing hidden: named", share(some, "named"), 0.02))
        rows.append(at_most("nothing hidden: unknown", share(some, "unknown"), 0.04))
    if hardly:
        rows.append(at_most("nothing nameable hidden: wrong", share(hardly, "wrong"), 0.02))
    return rows


def outsiders(cases: Cases) -> list[Row]:
    """Effects that no catalogue has, where an oracle sees them at all."""
    some = detectable([c for c in cases if c["what"] == "outside"])
    if not some:
        return []
    name, good = "outside the catalogue: unknown or remainder", ("unknown", "remainder")
    found = [at_least(name, share(some, *good), 0.90)]
    found.append({"study": "the same: a clean name", **share(some, "wrong")})
    found.append({"study": "the same: nothing said to be missing", **share(some, "silent")})
    if sure := clear(some):
        found.append({"study": f"the same, at {CLEAR:g} u or more", **share(sure, *good)})
        found.append({"study": "the same, there: a clean name", **share(sure, "wrong")})
    return found


def pairs(cases: Cases) -> list[Row]:
    """Two effects at once."""
    some = [c for c in cases if c["what"] == "pair"]
    if not some:
        return []
    good = [c for c in some if c["outcome"] in ("both", "one")]
    rows = [at_least("two effects: both, or one and a remainder", share(some, "both", "one"), 0.70)]
    both = share(good, "both") if good else {"value": 0.0, "low": 0.0, "high": 1.0, "cases": 0}
    return [*rows, at_least("two effects: both, of these", both, 0.50)]


def closing(cases: Cases) -> list[Row]:
    """Share of the reducible gap closed; what the best wrong effect gains beside it.

    Reducible is what no other values of the machine's parameters would explain.
    """
    some = detectable(
        [c for c in cases if c["what"] in ("single", "pair") and c["assumed_ratio"] == 1.0]
    )
    if not some:
        return []
    rows = [_median("share of the reducible gap closed", [closed(c) for c in some], 0.85, True)]
    hit = [closed(each) for each in some if each["outcome"] in CLOSING and each["left"]]
    if hit:
        rows.append({"study": "the same, where it is named", **_middle(hit)})
    wrong = [c["placebo"] for c in some if c["placebo"] is not None]
    name = "placebo: share of the misfit that the best wrong effect takes"
    return rows + ([{"study": name, **_middle(wrong)}] if wrong else [])


def closed(case: Case) -> float:
    """Share of the gap that is closed; 0 for an abstention or a wrong name."""
    if case["outcome"] not in CLOSING or not case["left"] or case["left"]["before"] <= 0.0:
        return 0.0
    return float(np.clip(1.0 - case["left"]["after"] / case["left"]["before"], 0.0, 1.0))


def sizes(cases: Cases) -> list[Row]:
    """Errors of effects' parameters, and whether their intervals hold the truth."""
    some = [c for c in cases if c["what"] in ("single", "closures") and c["assumed_ratio"] == 1.0]
    found = [each for c in some for each in c["parameters"].values()]
    if not found:
        return []
    held = share([{"outcome": "covers" if each["covers"] else ""} for each in found], "covers")
    within = 0.90 <= held["value"] <= 0.98
    bound = 0.98 if held["value"] > 0.98 else 0.90
    name = "coverage of 95 % intervals"
    return [
        _median("error of the effect's parameter", [each["error"] for each in found], 0.05, False),
        *_sharpest(some),
        {**must_show(name, held["value"], bound, within), **_beside(held)},
    ]


def _sharpest(cases: Cases) -> list[Row]:
    """What the error would be, were parameters known just as sharply as the oracle detects.

    Of size s u, an estimate whose test has the oracle's power at u has a standard deviation of
    1 / (s (z_95 + z_80)) of the size; half of its errors are below 0.674 of that.
    """
    normal = NormalDist()
    apart = normal.inv_cdf(1.0 - FALSE_ALARM) + normal.inv_cdf(POWER)
    sizes = [c["times"] for c in cases for _ in c["parameters"] if c["times"]]
    errors = [normal.inv_cdf(0.75) / (apart * size) for size in sizes]
    name = "the same, were it known as sharply as the oracle detects"
    return [{"study": name, **_middle(errors)}] if errors else []


def assumed_wrong(cases: Cases) -> list[Row]:
    """Wrong names with a wrong assumed scatter, beside the same cases with the right one."""
    rows = []
    for factor in sorted({c["assumed_ratio"] for c in cases} - {1.0}):
        some = [c for c in cases if c["assumed_ratio"] == factor]
        again = {(c["what"], c["protocol"], c["seed"]) for c in some}
        right = [c for c in cases if c["assumed_ratio"] == 1.0]
        right = [c for c in right if (c["what"], c["protocol"], c["seed"]) in again]
        if right:
            bound = 2.0 * share(right, "wrong", "named")["value"]
            name = f"wrong names, scatter assumed x{factor:g}"
            rows.append(at_most(name, share(some, "wrong", "named"), bound))
    return rows


def next_run(cases: Cases) -> list[Row]:
    """Open cases that the suggested run resolves, beyond those that any run resolves.

    Any run is logged as the others are; beside it, without a bound, with the suggestion's channels.
    """
    some = [c for c in cases if c["what"] == "single" and c["protocol"] == "poor"]
    some = [c for c in some if c["verdict"] in ("one_of", "unknown") and c["assumed_ratio"] == 1.0]
    ends = [c["after"] for c in some]
    if not some:
        return []
    proposals = {
        "study": "class or unknown, poor",
        "cases": len(some),
        "next run proposed": sum(map(bool, ends)),
    }
    points, same_channels = _points(ends, "any"), _points(ends, "same_channels")
    name = "resolved by the suggested run rather than any [points]"
    row = must_show(name, points["value"], 15.0, points["value"] >= 15.0)
    also = {"study": "the same, any run with the suggestion's channels [points]", **same_channels}
    return [proposals, {**row, **points}, also]


def _points(ends: Sequence[dict[str, str]], other: str) -> Row:
    gains = np.array([_gained(each, other) for each in ends])
    picks = np.random.default_rng(0).integers(0, gains.size, (2000, gains.size))
    low, high = np.percentile(gains[picks].mean(axis=1), (2.5, 97.5)).tolist()
    return {"value": float(gains.mean()), "low": low, "high": high, "cases": len(ends)}


def _gained(end: dict[str, str], other: str) -> float:
    """Points that the suggested run is worth beyond another; none where no run was suggested."""
    if not end:
        return 0.0
    rival = end.get(other, end["any"])
    return 100.0 * ((end["suggested"] == "right") - float(rival == "right"))


def seconds(cases: Cases) -> list[Row]:
    """Time of one diagnosis of twelve recordings."""
    some = [c["seconds"] for c in cases if c["protocol"].startswith("poor")]
    name = "one diagnosis, twelve recordings [s]"
    return [_median(name, some, SECONDS, False)] if some else []


def confusion(cases: Cases) -> dict[str, dict[str, int]]:
    """How often each hidden effect gets each answer; classes in the order of their names."""
    table: dict[str, Counter] = {}
    for case in cases:
        if "outcome" in case and case["assumed_ratio"] == 1.0:
            answer = " | ".join(sorted(case["named"])) or case["verdict"]
            table.setdefault(" + ".join(case["effects"]) or "nothing", Counter())[answer] += 1
    return {true: dict(answers.most_common()) for true, answers in sorted(table.items())}


def confusion_rows(table: dict[str, dict[str, int]]) -> list[Row]:
    """The same for a terminal: a line for each hidden effect."""
    return [
        {
            "hidden": true,
            "cases": sum(answers.values()),
            "answered": ", ".join(f"{answer} {count}" for answer, count in answers.items()),
        }
        for true, answers in table.items()
    ]


def _row(name: str, cases: Cases) -> Row:
    """Counts of one kind; what could not be made is no case of the diagnosis."""
    made = [case for case in cases if "outcome" in case]
    counts = Counter(case["outcome"] for case in made)
    seen = {"nameable": len(detectable(made)), "clear": len(clear(made))}
    spent = float(np.median([c["seconds"] for c in made])) if made else np.nan
    return {
        "study": name,
        "cases": len(made),
        "not made": len(cases) - len(made),
        **(seen if made and made[0]["what"] != "empty" else {}),
        **dict(sorted(counts.items())),
        "seconds": spent,
    }


def _median(name: str, samples: Sequence[float], bound: float, more: bool) -> Row:
    """A median that must be as high (`more`) or as low as `bound`."""
    found = _middle(samples)
    holds = found["value"] >= bound if more else found["value"] <= bound
    return {**must_show(name, found["value"], bound, holds), **found}


def _middle(samples: Sequence[float]) -> dict[str, Any]:
    return {"value": float(np.median(samples)), **interval(samples), "cases": len(samples)}


def _beside(found: dict[str, Any]) -> dict[str, Any]:
    return {key: found[key] for key in ("low", "high", "cases")}
