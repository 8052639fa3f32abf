"""From trials to a verdict: whether anything is missing, which effect is named, and why."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from hannes.campaigns.campaign import Campaign
from hannes.campaigns.segments import FEWEST_BLOCKS_TO_SPLIT, Segment, in_roles, may_be_split
from hannes.identification.holdout.effect_test import Trial, rivals
from hannes.identification.holdout.tuning import HOLDOUT
from hannes.identification.remainder import Remainder

VerdictFields = dict[str, Any]  # the verdict's first fields: verdict, effects, reason


def decided(
    trials: Sequence[Trial], nominal: float, left: float, lacking: str, note: str
) -> tuple[Trial | None, VerdictFields]:
    """Return the winner or None, and the verdict's first fields.

    trials: best first
    nominal, left: RMS of the worst channel as given and with the baseline refitted, in noise floors
    lacking: why nothing can be claimed;  note: how segments were cut
    """
    best = trials[0] if trials and trials[0].accepted else None
    if lacking:
        return None, _fields("undecided", lacking)
    if nominal <= HOLDOUT.agrees:
        return None, _fields(
            "no_gap", f"as given, the worst channel lies at {_times_text(nominal)}"
        )
    if best is not None:
        names = [best.name, *(each.name for each in rivals(best, trials))]
        kind = "named" if len(names) == 1 else "one_of"
        return best, _fields(kind, _chosen(best, note), names)
    kind = "recalibrated" if left <= HOLDOUT.agrees else "unknown"
    return None, _fields(
        kind, f"with the baseline refitted, the worst channel lies at {_times_text(left)}"
    )


def _fields(kind: str, reason: str, effects: Sequence[str] = ()) -> VerdictFields:
    return {"verdict": kind, "effects": list(effects), "reason": reason}


def _times_text(times: float) -> str:
    return f"{times:.1f} times the noise floor"


def lacking(campaign: Campaign, segments: Sequence[Segment], trials: Sequence[Trial]) -> str:
    """Why these recordings allow no claim, and what to record; empty where they do."""
    if len(campaign.entries) < 2 or not in_roles(segments, "show"):
        return (
            "no recording is left to show the result on that was never used to find it: "
            "record at least two more runs under the same command"
        )
    if not in_roles(segments, "select") or not in_roles(segments, "fit"):
        longer = f", or one of at least {FEWEST_BLOCKS_TO_SPLIT * campaign.plant.block:g} s"
        return (
            "no recording is left to choose by that was not fitted: record at least one more "
            f"run under the same command{longer * may_be_split(campaign.plant)}"
        )
    blocks = [trial.block_reductions.size for trial in trials if trial.applicable]
    if not blocks or max(blocks) >= HOLDOUT.fewest_blocks:
        return ""
    return (
        f"the recordings to choose by have {max(blocks)} blocks, of which chance favours all in "
        f"{100.0 * 0.5 ** max(blocks):.2g} %, more than the {100.0 * HOLDOUT.false_alarms:g} % "
        "asked for: record longer runs"
    )


def without_refit(fields: VerdictFields, why: str) -> VerdictFields:
    """A verdict that rests on refitted values, where these are not taken: `why`, or ""."""
    if not why or fields["verdict"] != "recalibrated":
        return fields
    return _fields("unknown", f"{fields['reason']}; but {why}")


def small_everywhere(fields: VerdictFields, worst: Remainder | None) -> VerdictFields:
    """A verdict of absence, or unknown where more than little is left in some place: `worst`."""
    if worst is None:
        return fields
    return _fields("unknown", f"{fields['reason']}; but it leaves {worst.text}")


def confirmed(
    fields: VerdictFields, gap: Mapping[str, Mapping[str, float]], refused: str
) -> VerdictFields:
    """Withdraw a name that the test recordings do not confirm; state a remainder.

    refused: why they speak against it channel by channel, or ""
    """
    if not fields["effects"]:
        return fields
    if refused:
        return _fields("unknown", f"{fields['reason']}; but {refused}")
    squares = [
        sum((each[key] / each["floor"]) ** 2 for each in gap.values())
        for key in ("before", "after")
    ]
    if squares[1] >= squares[0]:
        reason = "an effect was chosen, but on the show recordings it closes nothing"
        return _fields("unknown", reason)
    worst = max(each["after"] / each["floor"] for each in gap.values())
    if fields["verdict"] == "named" and worst > HOLDOUT.agrees:
        reason = f"{fields['reason']}; what remains is {_times_text(worst)}"
        return {**fields, "verdict": "named_with_remainder", "reason": reason}
    return fields


def _chosen(best: Trial, note: str) -> str:
    better = int(np.sum(best.block_reductions > 0.0))
    text = (
        f"on recordings not fitted it explains {100 * best.share:.0f} % of the misfit above the "
        f"noise floor, in {better} of {best.block_reductions.size} blocks, and its size lies "
        f"{best.evidence:.1f} standard deviations from none"
    )
    return f"{text}; {note}" if note else text
