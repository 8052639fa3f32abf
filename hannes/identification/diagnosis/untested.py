"""What a verdict of absence must say of tests that could not have fired in these recordings."""

from collections.abc import Sequence

from hannes.identification.diagnosis.repeat_groups import Group
from hannes.identification.diagnosis.trend import ordered
from hannes.identification.diagnosis.trials import SearchResult
from hannes.identification.diagnosis.tuning import VERDICT

ABSENCE = ("no_gap", "recalibrated")


def untested(found: SearchResult, kind: str) -> list[str]:
    """A sentence for each such test; empty where something is said to be missing."""
    if kind not in ABSENCE:
        return []
    groups = found.baseline.model.groups
    said = [_short(groups)]
    if not found.baseline.noise.simulated_noise:
        said.append(_from_repeats(groups))
    if not any(ordered(group) for group in groups):
        said.append(
            f"a change from run to run could not show: that needs {VERDICT.fewest_repeats} "
            "repeats of one command"
        )
    elif not found.guesses:
        said.append("a change from run to run could not show: there is no effect that might grow")
    return [each for each in said if each]


def _short(groups: Sequence[Group]) -> str:
    """Of commands too short to see whether bins of what is left follow each other; "" for none."""
    least = 2 * VERDICT.slow_components[-1] + 1
    short = [group for group in groups if group.bins < least]
    if not short:
        return ""
    bins = max(group.bins for group in short)
    which = "" if len(short) == len(groups) else f" of {len(short)} of {len(groups)} commands"
    return (
        f"whether bins of what is left{which} follow each other was not tested: that needs {least} "
        f"bins of a channel, and there are {'at most ' * (len(short) > 1)}{bins}"
    )


def _from_repeats(groups: Sequence[Group]) -> str:
    """What noise is known from, where it cannot be simulated."""
    most = max(group.count for group in groups)
    if most < 2:
        return (
            "no command was repeated, so noise is known from how rough channels are alone: little "
            "that is missing could hide in what runs differ by"
        )
    return (
        f"noise is known from {'at most ' * (len(groups) > 1)}{most} repeats alone: little that is "
        "missing could hide in what they differ by"
    )
