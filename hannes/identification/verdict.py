"""The verdict of a diagnosis: what verdict.json holds, and the sentence a person reads first."""

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any

from hannes.core.io.provenance import versions
from hannes.identification.effect_words import effect_words
from hannes.identification.next_step import next_steps
from hannes.identification.probability_words import probability_sentence
from hannes.identification.shape_words import shape_sentence
from hannes.identification.size_words import readable_unit, rounded, size_text, value_text

MOST_MOVED = 5  # parameters in the line of a terminal
FAINT = 0.2  # squared noise floors, mean over channels: a gap that is less above one is not visible
UNSEEN = 0.01  # of the reducible gap, below which unfitted recordings show nothing
LITTLE = 1.2  # noise floors on unfitted recordings: what is little more than that
REMAINING = ("one_of", "named_with_remainder")  # verdicts that say what is left


@dataclass(frozen=True, repr=False)
class Verdict:
    """The result contract: every field is plain data.

    gap: channel -> unit, as_given, before (baseline refitted), after, floor: RMS on `gap_on`, the
    test recordings where there are any; and all three in percent of the recorded channel's RMS.
    parameters: full name -> value, unit, low, high (95 %), off (where its effect vanishes).
    cautions: warnings of the data check.
    confusability: `effects` and their `cosines`, row by row: cosine similarity of the signatures of
    two effects in these recordings, beyond what the machine's parameters can do; 1 is the same.
    nearest: of an unknown, candidates that come nearest: `effects`, `explains` (share of what is
    missing), `why_not`.
    goes_with: what the refitted baseline leaves (`baseline`) and what the result leaves (`left`) go
    with: `sentence` and its `statements`.
    shape: of an unknown, the likeliest generic disturbance: `name`, `meaning`, `axis`, `value` with
    its band, `parameters`, `closes`, the share of the reducible gap, whether that is `shown`, and
    `explains`, the share of the misfit; or `why_not`.
    each_explains: of several effects each: the RMS of each channel of unfitted recordings `without`
    it, and the share that it alone `explains` of the reducible gap.
    probabilities: of the `answer`; that `nothing` is missing, that it is `something_else`, and of
    `effects`, rows of `effects` and `probability`, best first. Empty where they are not known.
    baseline: `intervals_from`, and `parameters` refitted without any new effect, those moved most
    first: name, of (an object), unit, nominal, value, low, high (95 %), moved (prior deviations).
    """

    verdict: str
    effects: list[str]
    parameters: dict[str, dict[str, Any]]
    gap: dict[str, dict[str, Any]]
    where: list[dict[str, Any]]
    candidates: list[dict[str, Any]]
    reason: str
    tried: list[dict[str, Any]]
    alpha: float
    recordings: dict[str, list[str]]
    seed: int
    gap_on: str = ""
    floor_from: str = ""
    cut: str = ""
    cautions: list[str] = field(default_factory=list)
    next_run: dict[str, Any] | None = None
    smallest_detectable: dict[str, Any] | None = None
    confusability: dict[str, Any] | None = None
    baseline: dict[str, Any] | None = None
    nearest: list[dict[str, Any]] = field(default_factory=list)
    goes_with: dict[str, Any] = field(default_factory=dict)
    shape: dict[str, Any] = field(default_factory=dict)
    each_explains: dict[str, dict[str, Any]] = field(default_factory=dict)
    probabilities: dict[str, Any] = field(default_factory=dict)
    versions: dict[str, str] = field(default_factory=versions)

    def __repr__(self) -> str:
        return f"Verdict({', '.join([self.verdict, *self.effects])})"

    def json(self) -> str:
        """Text of verdict.json, keys in the order of the contract."""
        return json.dumps(asdict(self), indent=2, ensure_ascii=False, allow_nan=False) + "\n"

    @property
    def sentence(self) -> str:
        """The result in one sentence."""
        return SENTENCES[self.verdict](self)

    @property
    def advice(self) -> str:
        """The run worth recording next, in one sentence; an empty string where there is none."""
        if not self.next_run:
            return ""
        also = " and ".join(self.next_run.get("also_log", ()))
        logged = f", with {also} logged" if also else ""
        return f"Record next: {self.next_run['experiment']}{logged}; {self.next_run['why']}."

    @property
    def disagreement(self) -> str:
        """Where the refitted baseline disagrees most, in one sentence; empty where it does not."""
        if not self.where or self.where[0]["times_floor"] <= 1.0:
            return ""
        worst = self.where[0]
        return (
            f"In the fitted recordings, without any new effect, it disagrees most in "
            f"{worst['channel']}, {worst['phase']}: "
            f"{rounded(worst['times_floor'])} times the noise floor."
        )

    @property
    def comes_nearest(self) -> list[str]:
        """What comes nearest to an unknown, and why it is not believed; a sentence each reason."""
        alike: dict[str, list[str]] = {}
        for each in self.nearest:
            share = f"({100.0 * each['explains']:.0f} % of what is missing)"
            name = " with ".join(map(effect_words, each["effects"]))
            alike.setdefault(each["why_not"], []).append(f"{name} {share}")
        return [
            f"Nearest: {', '.join(names)}. Not believed: {why}." for why, names in alike.items()
        ]

    @property
    def refit_taken(self) -> bool:
        """Whether the gaps before the result are of a refitted machine, not of the one as given."""
        return any(each["before"] != each["as_given"] for each in self.gap.values())

    @property
    def patterns(self) -> list[str]:
        """What the residual goes with, in a sentence each, where it is beyond chance."""
        found = [
            f"{self._of(key)}: {each['sentence'][:1].lower()}{each['sentence'][1:]}"
            for key, each in self.goes_with.items()
            if each["sentence"]
        ]
        left = self.goes_with.get("left", {})
        if self.verdict in REMAINING and left.get("tested") and not left["sentence"]:
            found.append(f"{self._of('left')}: nothing that repeats share beyond chance.")
        return found

    def _of(self, key: str) -> str:
        """Of what residual a sentence is."""
        if key == "baseline":
            return "What is left without any new effect"
        joint = " or " if self.verdict == "one_of" else " and "
        return f"What is left beside {joint.join(map(effect_words, self.effects))}"

    @property
    def described(self) -> str:
        """The shape of what is missing, in two sentences; empty where it has none."""
        return shape_sentence(self.shape)

    @property
    def how_probable(self) -> str:
        """The probability of the answer, and what else may be; empty where it is not known."""
        return probability_sentence(self.probabilities, self.verdict, self.effects)

    @property
    def next_steps(self) -> list[str]:
        """What to do now, in order, a sentence or two each."""
        return next_steps(self.verdict, self.advice)

    def summary(self) -> str:
        """Some lines for a terminal."""
        lines = [*(f"caution: {each}" for each in self.cautions), self.sentence, self.reason]
        lines += [self.how_probable] if self.probabilities else []
        lines += [_moved_most(self)] if self.verdict == "recalibrated" and self.baseline else []
        lines += [self.disagreement] if self.disagreement else []
        lines += [*self.patterns, *self.comes_nearest]
        lines += [self.described] if self.shape else []
        lines += ["next:", *(f"  {k}. {each}" for k, each in enumerate(self.next_steps, 1))]
        if self.gap:
            lines.append(f"gap on {self.gap_on or 'the recordings in role show'}:")
        refit = "baseline refitted" if self.refit_taken else "no other values taken"
        for name, gap in self.gap.items():
            shown = " -> ".join(f"{gap[key]:.3g}" for key in ("as_given", "before", "after"))
            unit = "" if gap["unit"] == "1" else f" {gap['unit']}"
            lines.append(
                f"  {name}: {shown}{unit} (as given -> {refit} -> result; "
                f"noise floor {gap['floor']:.2g})"
            )
        if self.gap and self.floor_from:
            lines.append(f"noise floor: {self.floor_from}")
        return "\n".join(lines)


def explained(gap: dict[str, dict[str, Any]]) -> float:
    """Share of the reducible gap (before, above the noise floor) that is gone after; 0 to 1."""
    before = sum((each["before"] / each["floor"]) ** 2 - 1.0 for each in gap.values())
    gone = sum((each["before"] ** 2 - each["after"] ** 2) / each["floor"] ** 2
               for each in gap.values())  # fmt: skip
    return min(1.0, max(0.0, gone / before)) if before > 0.0 else 0.0


def faint(gap: dict[str, dict[str, Any]]) -> bool:
    """Whether the baseline is hardly further off than repeats are from each other."""
    above = [(each["before"] / each["floor"]) ** 2 - 1.0 for each in gap.values()]
    return bool(sum(above) < FAINT * len(above))


def refitted_text(row: Mapping[str, Any]) -> tuple[str, str, str]:
    """Name, nominal, and refitted value of a parameter of the baseline, in a readable unit."""
    unit, factor = readable_unit(row["unit"])
    name = f"{row['name']} ({row['of']})" if row["of"] else row["name"]
    nominal, value = (f"{factor * row[key]:.4g}" for key in ("nominal", "value"))
    return name, nominal, value if unit == "1" else f"{value} {unit}"


def _moved_most(result: Verdict) -> str:
    """The parameters that moved most, in one line."""
    rows = (result.baseline or {})["parameters"][:MOST_MOVED]
    shown = []
    for row in rows:
        name, nominal, value = refitted_text(row)
        shown.append(f"{name} {nominal} -> {value} ({row['moved']:+.1f})")
    return f"moved most (in prior standard deviations): {', '.join(shown)}"


def indistinguishable(parameters: Mapping[str, Mapping[str, Any]]) -> list[str]:
    """Names of fitted parameters whose interval contains the value at which they do nothing."""
    return [
        name
        for name, each in parameters.items()
        if each.get("off") is not None and each["low"] <= each["off"] <= each["high"]
    ]


def _named(result: Verdict, rest: str = "") -> str:
    """The effects with the parameters that are certain; then those that may be zero."""
    vague = indistinguishable(result.parameters)
    clear = [name for name in result.parameters if name not in vague] or vague
    named = " and ".join(_effect_text(name, clear, result) for name in result.effects)
    verb = "explains" if len(result.effects) == 1 else "explain"
    share = f"{100.0 * explained(result.gap):.0f} % of the reducible gap"
    if explained(result.gap) < UNSEEN:
        share = "what the fitted recordings show; those not fitted do not show it"
    if faint(result.gap):
        share = "what no other values do; it is less than what repeats differ by"
    line = f"{named[:1].upper()}{named[1:]}, {verb} {share}{rest}."
    if not vague:
        return line
    unclear = ", ".join(_parameter_text(name, result) for name in vague)
    return f"{line} Not distinguishable from no effect: {unclear}."


def _effect_text(effect: str, clear: Sequence[str], result: Verdict) -> str:
    """`leader slack, length 3.1 mm (2.9 to 3.3)`; a single effect owns all parameters."""
    alone = len(result.effects) == 1
    own = [name for name in clear if alone or name.partition(".")[0] == effect.rpartition(":")[2]]
    return ", ".join([effect_words(effect), *(_parameter_text(name, result) for name in own)])


def _parameter_text(name: str, result: Verdict) -> str:
    return f"{name.rpartition('.')[2].replace('_', ' ')} {size_text(result.parameters[name])}"


def _with_remainder(result: Verdict) -> str:
    """What is left comes first: the name alone would promise too much."""
    named = _named(result)
    named = named[:1].lower() + named[1:]
    above = max((each["after"] / each["floor"] for each in result.gap.values()), default=0.0)
    if explained(result.gap) > 0.995 and above < LITTLE:
        return f"A little above the noise floor remains: {named}"
    return f"Something else is missing, too: {named}"


def _one_of(result: Verdict) -> str:
    names = " or ".join(_member(name, result) for name in result.effects)
    return f"One effect is missing, {names}: these recordings cannot separate them."


def _member(effect: str, result: Verdict) -> str:
    """`leader slack (length 3.1 mm)`: one of a class with its size, were it the one."""
    own = effect.rpartition(":")[2]
    sizes = {n: p for n, p in result.parameters.items() if n.partition(".")[0] == own}
    found = (each.get("sizes", {}) for each in result.candidates if each["effect"] == effect)
    shown = ", ".join(
        f"{name.rpartition('.')[2].replace('_', ' ')} {value_text(each)}"
        for name, each in (sizes or next(found, {})).items()
    )
    return f"{effect_words(effect)} ({shown})" if shown else effect_words(effect)


def _unknown(result: Verdict) -> str:
    """It follows the probability: what stands out in one place may be chance."""
    if result.probabilities.get("nothing", 0.0) >= 0.5:
        return "It is not known whether something is missing: most agrees, one thing stands out."
    return "Something is missing, and no effect can be named for it."


SENTENCES: Mapping[str, Callable[[Verdict], str]] = {
    "no_gap": lambda result: "The simulation as given agrees with the recordings.",
    "recalibrated": lambda result: (
        "Parameters were off; refitted, nothing that shows here is missing."
    ),
    "named": _named,
    "one_of": _one_of,
    "named_with_remainder": _with_remainder,
    "unknown": _unknown,
    "undecided": lambda result: "These recordings do not decide it.",
}
