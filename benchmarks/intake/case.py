"""One case: a fault of one kind and strength in one log, what is found of it, and its mending."""

import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.intake.bases import MACHINES, Base, Logger, base, count, logged
from benchmarks.intake.consequence import consequence
from benchmarks.intake.log import Kind, Log, all_kinds
from benchmarks.intake.mapped import Mapping, mended, recordings, sound_mapping
from hannes.campaigns.check import check
from hannes.campaigns.quality.finding import Finding
from hannes.campaigns.quality.mends import NO_FILE
from hannes.core.errors import BadInput

STRENGTHS = {"gross": (1.0, 4.0), "middling": (1.0 / 3.0, 1.0), "small": (0.03, 1.0 / 3.0)}
HARMLESS = 1.0 / 3.0  # consequence from which a mended log still misleads
HALVINGS, ROUNDS, TRIES = 10, 4, 20
SAME = 1.5  # times the consequence that the sound log has by the samples that are left alone
KEPT = 0.8  # of the rows, that a restored log has
RATES = (1000.0, 1000.0, 500.0, 250.0)


@dataclass(frozen=True)
class Spoiled:
    """A run, its sound log, the same spoiled, and by how much."""

    run: Base
    sound: Log
    log: Log
    size: float
    consequence: float


def case(name: str, strength: str, seed: int) -> dict[str, Any]:
    """What became of one fault; see `study` for the row's keys."""
    kind = all_kinds()[name]
    for attempt in range(TRIES):
        rng = np.random.default_rng([seed, attempt, *name.encode()])
        spoiled = _spoiled(kind, strength, rng)
        if spoiled is not None:
            return {"machine": spoiled.run.machine, "run": spoiled.run.number, **_judged(
                kind, spoiled)}  # fmt: skip
    return {"strength": "none"}


def _spoiled(kind: Kind, strength: str, rng: np.random.Generator) -> Spoiled | None:
    machine = str(rng.choice(MACHINES, p=[0.5, 0.25, 0.25]))
    run = base(machine, int(rng.integers(count(machine))))
    referenced = bool(rng.random() < 0.6) or machine == "axis"  # which needs its command
    sound = logged(run, Logger(float(rng.choice(RATES))), referenced, rng)
    state, goal = int(rng.integers(2**32)), _goal(strength, rng)

    def put(size: float) -> tuple[Log | None, float]:
        log = kind.inject(sound, size, np.random.default_rng(state))
        return log, 0.0 if log is None else consequence(run, log)

    size = _searched(put, goal) if kind.graded else 1.0
    log, found = put(size)
    return None if log is None else Spoiled(run, sound, log, size, found)


def _goal(strength: str, rng: np.random.Generator) -> float:
    low, high = STRENGTHS[strength]
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def _searched(put: Any, goal: float) -> float:
    """The size whose consequence is the goal, by halving of a range of sizes in ratio."""
    low, high = 1e-5, 1.0
    for _ in range(HALVINGS):
        middle = float(np.sqrt(low * high))
        low, high = (middle, high) if put(middle)[1] < goal else (low, middle)
    return high


def strength_of(size: float) -> str:
    """Name of a consequence."""
    return "gross" if size >= 1.0 else "middling" if size >= HARMLESS else "small"


def serious(found: Sequence[Finding]) -> list[Finding]:
    """Without the notes."""
    return [each for each in found if each.level != "note"]


def _judged(kind: Kind, spoiled: Spoiled) -> dict[str, Any]:
    with tempfile.TemporaryDirectory() as folder:
        mapping = sound_mapping(spoiled.run, spoiled.sound)
        usual = {
            (f.kind, f.channel)
            for f in _sorted(_looked(spoiled, spoiled.sound, mapping, folder)[1])
        }
        log = spoiled.log
        found = _sorted(_looked(spoiled, log, mapping, folder)[1])
        new = [each for each in found if (each.kind, each.channel) not in usual]
        lines = [str(each) for each in new]
        row = {
            "strength": strength_of(spoiled.consequence),
            "consequence": round(spoiled.consequence, 4),
            "size": round(spoiled.size, 6),
            "referenced": "reference" in spoiled.sound.columns,
            "restorable": kind.restorable,
            "hidden": kind.hidden(spoiled.sound, spoiled.size) or log.reason,
            "found": bool(new),
            "named": bool(new) and _right(kind, new[0]),
            "lines": lines[:4],
        }
        if new and row["strength"] != "small":  # of which only what is found counts
            row |= _mending(kind, spoiled, mapping, new, usual, folder)
    return row


def _right(kind: Kind, finding: Finding) -> bool:
    text = f"{finding.kind} {finding.text}".lower()
    return any(word.lower() in text for word in kind.right)


def _looked(
    spoiled: Spoiled, log: Log, mapping: Mapping, folder: str
) -> tuple[list[Log], list[list[Finding]]]:
    """The recordings of a log, as logs, and what is serious of each; a refusal is a finding."""
    try:
        made = recordings(spoiled.run, log, mapping, Path(folder))
    except BadInput as error:
        mends = getattr(error, "mend", ())
        return [], [[Finding("fault", "refused", "time", str(error), mend=mends)]]
    plant = plant_of(log.machine)
    found = [serious(check(each.recording, plant)) for each in made]
    return [Log(log.machine, dict(each.recording.channels)) for each in made], found


def _kept(
    logs: list[Log], found: list[list[Finding]]
) -> tuple[list[Log], list[Finding]]:  # fmt: skip
    """Without those of several runs in a file that a finding says to leave out."""
    good = [not any(set(NO_FILE) & set(each.mend) for each in some) for some in found]
    if len(logs) > 1 and any(good):
        logs = [log for log, is_good in zip(logs, good, strict=True) if is_good]
        found = [some for some, is_good in zip(found, good, strict=True) if is_good]
    return logs, _sorted(found)


def _sorted(found: list[list[Finding]]) -> list[Finding]:
    """Faults first."""
    return sorted((each for some in found for each in some), key=lambda each: each.level != "fault")


def plant_of(machine: str) -> Any:
    """The plant that a machine's recordings are of."""
    from benchmarks.intake.servo_plant import Servo
    from hannes.plants.protocol import shipped_plant

    return Servo() if machine == "servo" else shipped_plant(machine)


def _mending(
    kind: Kind, spoiled: Spoiled, mapping: Mapping, found: list[Finding], usual: set[Any],
    folder: str,
) -> dict[str, Any]:  # fmt: skip
    """Change the mapping as the findings say, convert and check again, compare with the sound."""
    keys: list[str] = []
    logs: list[Log] = []
    for _ in range(ROUNDS):
        mends = [line for each in found for line in each.mend]
        if not mends:
            break
        keys += mends
        changed = mended(mapping, mends)
        if changed is None:
            return {"keys": keys[:6], "mended": not kind.restorable, "how": "left out"}
        mapping = changed
        logs, found = _kept(*_looked(spoiled, spoiled.log, mapping, folder))
        found = [each for each in found if (each.kind, each.channel) not in usual]
        found = [each for each in found if each.kind != "gap"]  # what was left out is a gap
        if not found:
            break
    left = max((consequence(spoiled.run, log) for log in logs), default=float("inf"))
    whole = all(log.time.size >= KEPT * spoiled.sound.time.size for log in logs)
    kept = spoiled.sound.columns.keys() <= set.intersection(*(set(x.columns) for x in logs)) if (
        logs) else False  # fmt: skip
    good = bool(keys) and not found and all(_harmless(spoiled, log) for log in logs)
    good &= (whole and kept) if kind.restorable else True
    return {
        "keys": keys[:6], "mended": good, "left": round(min(left, 1e6), 4),
        "still": [str(each) for each in found][:2],
    }  # fmt: skip


def _harmless(spoiled: Spoiled, log: Log) -> bool:
    """Whether a mended log misleads no more than the sound one does by the same samples alone."""
    left = consequence(spoiled.run, log)
    if left < HARMLESS:
        return True
    sound = spoiled.sound
    columns = {n: np.interp(log.time, sound.time, sound.columns[n]) for n in log.columns}
    return left < SAME * consequence(spoiled.run, Log(log.machine, {**columns, "time": log.time}))
