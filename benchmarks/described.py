"""Does a generic disturbance follow the machine under another command, where no law is known?

Hands of the independent truth (benchmarks/truth) hide what no catalogue has: the five kinds of
development, each at a fifth of its range up to its end, log-uniform. Every joint is 1 % off for
itself. The campaign is six free closures and six grasps at the paper's command. Four other commands
are recorded beside it, four times each, and not given: closures at half and at 0.15 of the speed,
grasps at a quarter of the speed and to 0.85 of the amplitude.

There the refitted baseline and the described machine are simulated whole. Counted is the share of
the reducible gap that the description closes: of the squared residuals of each place, in noise
floors, less what the mean of repeats still holds of noise. A place is a command, a channel and a
phase. Cases count that show: three noise floors in one place or more. A case without a description,
or with a name, closes nothing.
"""

import tempfile
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks import study
from benchmarks.guarding.plan import SPREAD
from benchmarks.harness import Row, given, must_show
from benchmarks.naming_study.draw import MENU, amplitudes
from benchmarks.truth.campaign import Made, make
from benchmarks.truth.effects import OUTSIDE, SIZES
from benchmarks.truth.protocol import PROTOCOLS, Protocol
from hannes.campaigns.campaign import Entry, in_order
from hannes.campaigns.segments import Segment
from hannes.commands.diagnose import Diagnosis, diagnose
from hannes.core.errors import HannesError
from hannes.identification.diagnosis.before_after import left, simulated
from hannes.identification.diagnosis.fitted_deviations import with_deviations
from hannes.identification.remainder import Raw, Remainder, remainders

FOLDER = Path("results/benchmarks")
FIRST_SEED, CASES, QUICK = 340_000_000, 10, 1
LEAST_SHARE = 0.2  # of a range
SHOWS = 3.0  # noise floors
OTHER = ("void, half speed", "void, 0.15 speed", "dynamometer, 0.85 amplitude",
         "dynamometer, 0.25 speed")  # fmt: skip
CODE = ("hannes", "benchmarks.truth", "benchmarks.described")


def plan() -> Protocol:
    """The poor protocol, and other commands after it."""
    poor = PROTOCOLS["poor"]
    more = [replace(MENU[name], repeats=4) for name in OTHER]
    return replace(poor, conditions=(*poor.conditions, *more))


def hidden(seed: int) -> dict[str, float]:
    """What a case hides, by full name [SI]; kinds take turns."""
    names = amplitudes(OUTSIDE)
    name, rng = names[seed % len(names)], np.random.default_rng([seed, 52])
    size = SIZES[name]
    low = max(size.low, LEAST_SHARE * size.high)
    found = {name: low * (size.high / low) ** rng.uniform()}
    for shape, each in SIZES.items():
        if shape.partition(".")[0] == name.partition(".")[0] and not each.amplitude:
            drawn = rng.uniform(each.low, each.high)
            found[shape] = float(round(drawn)) if each.unit == "1" else float(drawn)
    return found


def measured(kind: str, seed: int) -> dict[str, Any]:
    """A case: its verdict, its shape, and what is closed under other commands."""
    effects = hidden(seed)
    row: dict[str, Any] = {"code": study.code(*CODE), "hidden": effects}
    try:
        whole = make(plan(), seed, effects, SPREAD)
    except HannesError as failed:
        return {**row, "not_made": str(failed)}
    with tempfile.TemporaryDirectory() as folder:
        kept = {n: c for n, c in whole.conditions.items() if c not in OTHER}
        made = replace(whole, conditions=kept, recordings={n: whole.recordings[n] for n in kept})
        made.write(Path(folder))
        spent = time.process_time()
        try:
            found = diagnose(Path(folder) / "campaign.toml", progress=False)
        except HannesError as failed:
            return {**row, "verdict": "none", "reason": str(failed), **NOTHING}
    seconds = time.process_time() - spent
    return {**row, "processor_seconds": seconds, **described(found, whole)}


NOTHING = {"shape": "", "closes": 0.0, "elsewhere": 0.0, "shows": 0.0, "by_command": {}}


def described(found: Diagnosis, whole: Made, other: Sequence[str] = OTHER) -> dict[str, Any]:
    """The verdict, the shape, and the share closed under other commands, together and of each."""
    verdict = found.verdict
    row = {
        "verdict": verdict.verdict,
        "named": verdict.effects,
        "shape": verdict.shape.get("name", ""),
        "closes": verdict.shape.get("closes", 0.0),
        "why_not": verdict.shape.get("why_not", ""),
        "patterns": verdict.patterns,
    }
    runs = in_order([Entry(n, whole.recordings[n], c) for n, c in whole.conditions.items()])
    fresh = [
        Segment(each, "", np.ones(len(each.recording), bool))
        for each in runs
        if each.condition in other
    ]
    stages = _elsewhere(found, fresh)
    before, after = (_raw(found, fresh, stages, stage) for stage in (1, 2))
    places = remainders(found.campaign.plant, fresh, before, after, found.noise_floors)
    each = {c: _share([place for place in places if place.condition == c]) for c in other}
    shows = max(place.before for place in places)
    return {**row, "shows": shows, "elsewhere": _share(places), "by_command": each}


def _share(places: list[Remainder]) -> float:
    """Of the squared residuals of some places, what is gone after; 0 to 1."""
    before = sum(each.before**2 for each in places)
    after = sum(each.after**2 for each in places)
    return float(np.clip(1.0 - after / before, 0.0, 1.0)) if before else 0.0


def _elsewhere(found: Diagnosis, fresh: list[Segment]) -> list[Any]:
    """Runs of the refitted baseline, and of the described machine, of each fresh segment."""
    details = found.details
    assert details is not None
    made = details.shape.described if details.shape else None
    if made is None:
        model, points = (
            details.found.baseline.model,
            [details.found.nominal, *[details.stages.points[1]] * 2],
        )
    else:
        model, points = made.base.model, [made.nominal, made.base, made.point]
    entries, places = [each.entry for each in fresh], np.array([each.x for each in points])
    with model.work.in_any_case():
        runs = simulated(model, entries, places)
        return with_deviations(runs, entries, points[1:], details.found.variance_factor)


def _raw(found: Diagnosis, fresh: list[Segment], runs: list[Any], stage: int) -> Raw:
    """Simulated minus recorded of the fresh runs, at one stage."""
    return left(fresh, [each[stage] for each in runs], list(found.noise_floors))


def figures(done: list[dict[str, Any]]) -> tuple[list[Row], list[Row]]:
    """A row for each case, and what must be shown."""
    made = [each for each in done if "not_made" not in each]
    rows = [
        {
            "hidden": ", ".join(f"{n} {x:.3g}" for n, x in each["hidden"].items()),
            "verdict": " ".join([each["verdict"], *each.get("named", [])]),
            "shape": each["shape"],
            "closes_show": each["closes"],
            "closes_elsewhere": each["elsewhere"],
            "shows_floors": each["shows"],
        }
        for each in made
    ]
    shown = [each for each in made if each["shows"] > SHOWS]
    median = float(np.median([each["elsewhere"] for each in shown])) if shown else 0.0
    wrong = sum(bool(each.get("named")) for each in shown)
    bounds = [
        must_show("share closed under other commands, median of those that show", median, 0.6,
                  median >= 0.6),
        must_show("of those that show: a name", wrong, 1, wrong <= 1),
    ]  # fmt: skip
    return rows, bounds


def main() -> None:
    """Measure, print tables, write JSON where asked."""
    asked = study.parser("described", __doc__).parse_args()
    file = asked.cases or FOLDER / f"described{'-quick' * asked.quick}.jsonl"
    count = QUICK if asked.quick else CASES
    wanted = [("outside", FIRST_SEED + k) for k in range(count)][: asked.most]
    done = (
        list(study.read(file))
        if asked.show
        else study.run(file, wanted, measured, asked.resume, asked.workers)
    )
    rows, bounds = figures(done)
    given({"rows": rows, "must_show": bounds}, (rows, bounds), asked.json)


if __name__ == "__main__":
    main()
