"""What a verdict of absence must say of tests that could not have fired in these recordings."""

from hannes.identification.diagnosis.repeat_groups import Group
from hannes.identification.diagnosis.trials import SearchResult
from hannes.identification.diagnosis.tuning import VERDICT

ABSENCE = ("no_gap", "recalibrated")


def untested(found: SearchResult, kind: str) -> list[str]:
    """A sentence for each such test; empty where something is said to be missing."""
    if kind not in ABSENCE:
        return []
    groups, said = found.baseline.model.groups, []
    least = 2 * VERDICT.slow_components[-1] + 1
    if all(group.bins < least for group in groups):
        bins = max(group.bins for group in groups)
        said.append(
            f"whether what is left hangs together was not tested: that needs {least} bins of a "
            f"channel, and there are {bins}"
        )
    elif not found.baseline.noise.simulated_noise:
        runs = max(group.count for group in groups)
        said.append(
            f"noise is known from {runs} repeats alone: little that is missing could hide in what "
            "they differ by"
        )
    if not any(_ordered(group) for group in groups):
        said.append(
            f"a change from run to run could not show: that needs {VERDICT.fewest_repeats} "
            "repeats of one command"
        )
    return said


def _ordered(group: Group) -> bool:
    return group.count >= VERDICT.fewest_repeats
