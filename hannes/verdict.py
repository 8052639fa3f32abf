"""The verdict of a diagnosis: what verdict.json holds, and the sentence a person reads first."""

import json
from dataclasses import asdict, dataclass, field
from typing import Any

from hannes.versions import versions

VERDICTS = (
    "no_gap",
    "recalibrated",
    "named",
    "one_of",
    "named_with_remainder",
    "unknown",
    "undecided",
)
_SMALLER = {"m": ("mm", 1e3), "s": ("ms", 1e3), "N m": ("mN m", 1e3)}


@dataclass(frozen=True)
class Verdict:
    """The result contract: every field is plain data; gaps are RMS on the show recordings.

    gap: channel -> unit, as_given, before (base refitted), after, floor, and all three gaps in
    percent of the recorded channel's RMS.
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
    floor_from: str = ""
    cut: str = ""
    next_run: dict[str, Any] | None = None
    smallest_detectable: dict[str, Any] | None = None
    versions: dict[str, str] = field(default_factory=versions)

    def json(self) -> str:
        """Text of verdict.json, keys in the order of the contract."""
        return json.dumps(asdict(self), indent=2, ensure_ascii=False, allow_nan=False) + "\n"

    @property
    def sentence(self) -> str:
        """The result in one sentence."""
        return SENTENCES[self.verdict](self)

    def summary(self) -> str:
        """Some five lines for a terminal."""
        lines = [self.sentence, self.reason]
        for name, gap in self.gap.items():
            shown = " -> ".join(f"{gap[key]:.3g}" for key in ("as_given", "before", "after"))
            lines.append(
                f"  {name}: {shown} {gap['unit']} (as given -> base refitted -> result; "
                f"floor {gap['floor']:.2g})"
            )
        return "\n".join(lines)


def explained(gap: dict[str, dict[str, Any]]) -> float:
    """Share of the reducible misfit (before, above the floor) that is gone after; 0 to 1."""
    before = sum((each["before"] / each["floor"]) ** 2 - 1.0 for each in gap.values())
    gone = sum((each["before"] ** 2 - each["after"] ** 2) / each["floor"] ** 2
               for each in gap.values())  # fmt: skip
    return min(1.0, max(0.0, gone / before)) if before > 0.0 else 0.0


def spoken(name: str) -> str:
    """An effect's name in words: `leader_slack` -> `leader slack`."""
    return name.rpartition(":")[2].replace("_", " ")


def sized(parameter: dict[str, Any]) -> str:
    """`3.1 mm (2.9 to 3.3)`."""
    unit, factor = _SMALLER.get(parameter["unit"], (parameter["unit"], 1.0))
    value, low, high = (factor * parameter[key] for key in ("value", "low", "high"))
    shown = f"{value:.3g}" if unit == "1" else f"{value:.3g} {unit}"
    return f"{shown} ({low:.3g} to {high:.3g})"


def _named(result: Verdict) -> str:
    sizes = [
        f"{name.rpartition('.')[2].replace('_', ' ')} {sized(each)}"
        for name, each in result.parameters.items()
    ]
    start = spoken(result.effects[0])
    share = 100.0 * explained(result.gap)
    return f"{start.capitalize()}, {', '.join(sizes)}, explains {share:.0f} % of the reducible gap."


def _with_remainder(result: Verdict) -> str:
    if explained(result.gap) > 0.995:
        return _named(result)[:-1] + "; a little above the floor remains."
    return _named(result)[:-1] + "; the rest is something else."


def _one_of(result: Verdict) -> str:
    names = " or ".join(spoken(name) for name in result.effects)
    return f"One effect is missing, {names}: these recordings cannot tell which."


SENTENCES = {
    "no_gap": lambda result: "The simulation as given agrees with the recordings.",
    "recalibrated": lambda result: "Parameters were off; refitted, nothing is missing.",
    "named": _named,
    "one_of": _one_of,
    "named_with_remainder": _with_remainder,
    "unknown": lambda result: "Something is missing, and no effect of the catalogue explains it.",
    "undecided": lambda result: "These recordings do not decide it.",
}
