"""Find where simulation and recordings disagree, and which effect the model is missing.

Order of work: roles first; floor; base refitted; each effect refitted on the same pieces; the
choice made on pieces that no fit has seen; then all but the show recordings refitted once more,
and the show recordings opened.
"""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from hannes import files
from hannes import pieces as cutting
from hannes.campaign import Campaign, Entry, read_campaign
from hannes.pieces import Piece, floors
from hannes.plant import Plant
from hannes.plant_file import plant_toml
from hannes.refit import Fitted, Misfit, Progress, fit
from hannes.trial import (
    ALPHA,
    Trial,
    inflated,
    judge,
    pooled,
    ranked,
    relative,
    rivals,
    rms,
    smallest_detectable,
    with_likeness,
)
from hannes.verdict import Verdict

WITHIN = 1.5  # times the floor: what repeats and a model that is nearly right leave
WORST = 12  # places of the where-map that are kept


@dataclass(frozen=True)
class Traces:
    """One recording and three simulations of it: channel -> array, shape (n,)."""

    entry: Entry
    time: np.ndarray
    mask: np.ndarray
    measured: dict[str, np.ndarray]
    as_given: dict[str, np.ndarray]
    before: dict[str, np.ndarray]
    after: dict[str, np.ndarray]


@dataclass(frozen=True)
class Diagnosis:
    """The verdict, the plant with what was found, and everything needed to draw it."""

    campaign: Campaign
    verdict: Verdict
    plant: Plant
    traces: tuple[Traces, ...]
    floors: dict[str, float]
    trials: tuple[Trial, ...]

    def write(self, folder: str | Path) -> Path:
        """Write verdict.json, hand.toml, report.html into `folder`, whole or not at all."""
        from hannes.report.diagnosis import page

        with files.atomic_folder(folder) as temporary:
            (temporary / "verdict.json").write_text(self.verdict.json(), encoding="utf-8")
            (temporary / "hand.toml").write_text(self.toml(), encoding="utf-8")
            (temporary / "report.html").write_text(page(self), encoding="utf-8")
        return Path(folder)

    def toml(self) -> str:
        """Text of the hand.toml of `plant`."""
        return plant_toml(self.plant, self.campaign.shipped, self.campaign.base)


def diagnose(
    campaign: Campaign | str | Path,
    *,
    out: str | Path | None = None,
    seed: int = 0,
    progress: bool | None = None,
) -> Diagnosis:
    """Diagnose a campaign, or the TOML file of one; writes to `out` where given.

    `progress`: a bar on standard error, by default where that is a terminal. Raises BadInput for
    what cannot be used, ComputationFailed where a simulation fails.
    """
    if not isinstance(campaign, Campaign):
        campaign = read_campaign(campaign, seed)
    with _bar(progress) as tell:
        result = _Work(campaign, seed, tell).result()
    if out is not None:
        result.write(out)
    return result


@contextmanager
def _bar(progress: bool | None) -> Iterator[Progress]:
    from tqdm import tqdm

    hidden = None if progress is None else not progress
    with tqdm(desc="diagnosing", unit=" steps", delay=2.0, disable=hidden, leave=False) as bar:

        def tell(text: str) -> None:
            bar.set_description(f"fitting {text}", refresh=False)
            bar.update()

        yield tell


class _Work:
    """One diagnosis in progress."""

    def __init__(self, campaign: Campaign, seed: int, tell: Progress) -> None:
        self.campaign, self.plant, self.seed, self.tell = campaign, campaign.plant, seed, tell
        self.pieces, self.note = cutting.cut(campaign)
        self.known = self.of("fit", "select") or self.pieces
        self.shown = self.of("show") or self.known
        self.floors, self.how = floors(self.plant, self.known)

    def of(self, *roles: str) -> list[Piece]:
        return cutting.of(self.pieces, *roles)

    def result(self) -> Diagnosis:
        fitted = self.of("fit") or self.known
        base, scales = self.base(fitted)
        trials = self.trials(fitted, base, scales)
        best, verdict = self.choice(trials, base)
        before = fit(Misfit(self.plant, self.known, scales), self.plant, base.values, self.tell)
        after = before
        if best is not None and best.fitted is not None:
            misfit = Misfit(self.plant, self.known, scales)
            after = fit(misfit, best.fitted.plant, best.fitted.values, self.tell)
        return self.closed(verdict, best, trials, before, after)

    def base(self, fitted: Sequence[Piece]) -> tuple[Fitted, dict[str, float]]:
        """Refit the base, twice: first by the floor, then by what it leaves."""
        first = Misfit(self.plant, fitted, self.floors)
        rough = fit(first, self.plant, tell=self.tell)
        scales = inflated(self.floors, first, rough)
        return fit(Misfit(self.plant, fitted, scales), self.plant, rough.values, self.tell), scales

    def trials(
        self, fitted: Sequence[Piece], base: Fitted, scales: Mapping[str, float]
    ) -> list[Trial]:
        chosen = Misfit(self.plant, self.of("select"), self.floors)
        rng = np.random.default_rng(self.seed)
        made = []
        present = {each.name for each in self.plant.effects}
        for name, effect in self.campaign.effects.items():
            if why := self.plant.accepts(effect):
                made.append(Trial(name, effect, f"not applicable: {why}"))
            elif effect.name in present:
                made.append(Trial(name, effect, "already in the model"))
            else:
                grown = self.plant.with_effects(effect)
                misfit = Misfit(self.plant, fitted, scales)
                trial = Trial(name, effect, fitted=fit(misfit, grown, base.values, self.tell))
                judgeable = bool(chosen.pieces)
                made.append(
                    judge(trial, chosen, base, rng)
                    if judgeable
                    else replace(trial, why="no recording is left to choose by")
                )
        return ranked(with_likeness(made))

    def choice(self, trials: Sequence[Trial], base: Fitted) -> tuple[Trial | None, dict]:
        """Return the winner or None, and the verdict's first fields."""
        given = self._times_floor(self.plant, {})
        left = self._times_floor(self.plant, base.values)
        best = trials[0] if trials and trials[0].accepted else None
        if lacking := self._lacking(trials):
            return None, {"verdict": "undecided", "effects": [], "reason": lacking}
        if best is not None and given > WITHIN:
            names = [best.name, *(each.name for each in rivals(best, trials))]
            kind = "named" if len(names) == 1 else "one_of"
            return best, {"verdict": kind, "effects": names, "reason": _chosen(best, self.note)}
        if given <= WITHIN:
            reason = f"as given, the worst channel lies at {given:.1f} times the floor"
            return None, {"verdict": "no_gap", "effects": [], "reason": reason}
        reason = f"with the base refitted, the worst channel lies at {left:.1f} times the floor"
        kind = "recalibrated" if left <= WITHIN else "unknown"
        return None, {"verdict": kind, "effects": [], "reason": reason}

    def _times_floor(self, plant: Plant, values: Mapping[str, float]) -> float:
        left = rms(Misfit(self.plant, self.known, self.floors), plant, values)
        return max(left[name] / self.floors[name] for name in left)

    def _lacking(self, trials: Sequence[Trial]) -> str:
        if len(self.campaign.entries) < 2 or not self.of("show"):
            return (
                "no recording is left to show the result on that was never used to find it: "
                "record at least two more runs under the same command"
            )
        if not self.of("select") or not self.of("fit"):
            return (
                "no recording is left to choose by that was not fitted: record at least one more "
                "run under the same command, or one of at least "
                f"{cutting.FEWEST_BLOCKS * self.plant.block:g} s"
            )
        blocks = [t.block_gains.size for t in trials if t.applicable]
        few = blocks and max(blocks) < 6
        return "the recordings to choose by are too short: record longer runs" if few else ""

    def closed(
        self,
        verdict: dict,
        best: Trial | None,
        trials: Sequence[Trial],
        before: Fitted,
        after: Fitted,
    ) -> Diagnosis:
        """Open the show recordings and put everything together."""
        gap = self.gap(before, after)
        verdict = _tempered(verdict, gap)
        found = after if verdict["effects"] else before
        usable = verdict["verdict"] not in ("undecided", "no_gap")
        result = Verdict(
            **verdict,
            parameters=_intervals(best, after) if verdict["effects"] and best else {},
            gap=gap if found is after else {n: {**g, **_undone(g)} for n, g in gap.items()},
            where=self.where(before),
            candidates=[_candidate(trial) for trial in trials if trial.applicable],
            tried=[_attempt(trial) for trial in trials],
            alpha=ALPHA,
            recordings={role: [p.entry.name for p in self.of(role)] for role in
                        ("fit", "select", "show")},
            seed=self.seed,
            floor_from=self.how,
            cut=self.note,
            smallest_detectable=smallest_detectable(trials) or None,
        )  # fmt: skip
        plant = found.plant.with_values(found.values) if usable else self.plant
        traces = tuple(self.traces(entry, before, found) for entry in self.campaign.entries)
        return Diagnosis(self.campaign, result, plant, traces, self.floors, tuple(trials))

    def gap(self, before: Fitted, after: Fitted) -> dict[str, dict]:
        misfit = Misfit(self.plant, self.shown, self.floors)
        stages = {
            "as_given": misfit.raw(self.plant, {}),
            "before": misfit.raw(before.plant, before.values),
            "after": misfit.raw(after.plant, after.values),
        }
        sizes = {key: pooled(raw, self.floors) for key, raw in stages.items()}
        return {
            name: {"unit": self.plant.channels[name]}
            | {key: sizes[key][name] for key in stages}
            | {"floor": self.floors[name]}
            | {f"{key}_percent": relative(raw, self.shown, name) for key, raw in stages.items()}
            for name in sizes["before"]
        }

    def where(self, before: Fitted) -> list[dict]:
        """Channel and phase of what the refitted base leaves, worst first."""
        raw = Misfit(self.plant, self.known, self.floors).raw(before.plant, before.values)
        places: dict[tuple[str, str], list[tuple[np.ndarray, np.ndarray, str]]] = {}
        for piece, channels in zip(self.known, raw, strict=True):
            time = piece.recording.time[piece.mask]
            for phase, mask in self.plant.phases(piece.recording).items():
                inside = mask[piece.mask]
                for name, values in channels.items():
                    if inside.any():
                        found = (values[inside], time[inside], piece.entry.name)
                        places.setdefault((name, phase), []).append(found)
        rows = [self._place(*key, parts) for key, parts in places.items()]
        return sorted(rows, key=lambda row: -row["times_floor"])[:WORST]

    def _place(
        self, name: str, phase: str, parts: Sequence[tuple[np.ndarray, np.ndarray, str]]
    ) -> dict:
        size = float(np.sqrt(np.mean(np.concatenate([part[0] for part in parts]) ** 2)))
        return {
            "channel": name,
            "phase": phase,
            "t0": float(min(part[1][0] for part in parts)),
            "t1": float(max(part[1][-1] for part in parts)),
            "rms": size,
            "times_floor": size / self.floors[name],
            "recordings": sorted({part[2] for part in parts}),
        }

    def traces(self, entry: Entry, before: Fitted, after: Fitted) -> Traces:
        recording = entry.recording
        runs = (
            self.plant.simulate({}, recording),
            before.plant.simulate(before.values, recording),
            after.plant.simulate(after.values, recording),
        )
        names = [name for name in self.floors if name in recording]
        mask = self.plant.judged_part(recording)
        measured = {name: recording[name] for name in names}
        simulated = ({name: run[name] for name in names} for run in runs)
        return Traces(entry, recording.time, mask, measured, *simulated)


def _chosen(best: Trial, note: str) -> str:
    better = int(np.sum(best.block_gains > 0.0))
    text = (
        f"on recordings not fitted it takes away {100 * best.share:.0f} % of the misfit above the "
        f"floor, in {better} of {best.block_gains.size} blocks, and its size lies "
        f"{best.evidence:.1f} standard deviations from none"
    )
    return f"{text}; {note}" if note else text


def _tempered(verdict: dict, gap: Mapping[str, Mapping[str, float]]) -> dict:
    """Take a name back that the show recordings do not bear out; tell a remainder."""
    if not verdict["effects"]:
        return verdict
    squares = [
        sum((each[key] / each["floor"]) ** 2 for each in gap.values())
        for key in ("before", "after")
    ]
    if squares[1] >= squares[0]:
        reason = "an effect was chosen, but on the show recordings it closes nothing"
        return {"verdict": "unknown", "effects": [], "reason": reason}
    worst = max(each["after"] / each["floor"] for each in gap.values())
    if verdict["verdict"] == "named" and worst > WITHIN:
        reason = f"{verdict['reason']}; what remains is {worst:.1f} times the floor"
        return {**verdict, "verdict": "named_with_remainder", "reason": reason}
    return verdict


def _undone(gap: Mapping[str, float]) -> dict[str, float]:
    return {"after": gap["before"], "after_percent": gap["before_percent"]}


def _intervals(best: Trial, after: Fitted) -> dict[str, dict]:
    """Value and 95 % interval of each of the effect's parameters, cut off at its bounds."""
    found = {}
    for each in best.effect.parameters:
        name = best.effect.full_name(each.name)
        value, reach = after.values[name], 1.96 * after.deviation(name)
        low, high = max(each.bounds[0], value - reach), min(each.bounds[1], value + reach)
        found[name] = {"value": value, "unit": each.unit, "low": low, "high": high}
    return found


def _candidate(trial: Trial) -> dict:
    return {
        "effect": trial.name,
        "evidence": trial.evidence,
        "gain_select": trial.share,
        "confusable_with": list(trial.confusable_with),
    }


def _attempt(trial: Trial) -> dict:
    return {
        "effect": trial.name,
        "applicable": trial.applicable,
        "accepted": trial.accepted,
        "why": trial.why or "accepted",
    }
