"""The last line of a command: what to type next, or which key to change."""

import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from hannes.campaigns.quality.finding import Finding
    from hannes.identification.calibration.result import Fit

FEW = 3  # files that a line names


def after_check(files: Sequence[str], faulty: Sequence[str]) -> str:
    """Of `hannes check FILES`; `faulty` are names of those with a fault."""
    again = _command("check", *files)
    if faulty:
        return f"next: mend {_named(faulty)} as the fault says, or leave it out; then: {again}"
    campaigns = [each for each in files if Path(each).suffix in (".toml", "")]
    if campaigns:
        missing, values = (_command(verb, campaigns[0]) for verb in ("diagnose", "calibrate"))
        return f"next: {missing} (what is missing), or: {values} (its parameters)"
    return _into_campaign(files)


def after_convert(mapping: str, outs: Sequence[str], found: Sequence[Sequence["Finding"]]) -> str:
    """Of `hannes convert`; `found` are the findings in each file written."""
    pairs = zip(outs, found, strict=True)
    faulty = [out for out, findings in pairs if any(each.level == "fault" for each in findings)]
    if faulty:
        return f"next: change {mapping} as the fault in {_named(faulty)} says, then convert again"
    return _into_campaign(outs)


def after_calibrate(campaign: str, out: str | Path, result: "Fit") -> str:
    """Of `hannes calibrate CAMPAIGN`, by the worst thing that it found."""
    from hannes.identification.calibration.identifiability import AT_BOUND, CONFOUNDED

    again = _command("calibrate", campaign)
    diagnosis = _command("diagnose", campaign)
    if result.found.interrupted:
        return f"next: {again}"
    if result.misleads:
        return f"next: {diagnosis}"
    left = {each.label: each.name for each in reversed(result.answers) if not each.identified}
    if name := left.get(CONFOUNDED):
        return f'next: leave "{name}" out of parameters in [calibrate], then: {again}'
    if name := left.get(AT_BOUND):
        return f'next: widen "{name}" in [calibrate.bounds], then: {again}'
    if left:
        name = next(iter(left.values()))
        return (
            f'next: leave "{name}" out of parameters in [calibrate], or record more; then: {again}'
        )
    return f"next: {diagnosis}; the fitted plant: {_command('hand', str(Path(out) / 'hand.toml'))}"


def _into_campaign(files: Sequence[str]) -> str:
    key = f'[[recording]] with file = "{files[0]}"'
    more = ", and one for each other" if len(files) > 1 else ""
    return f"next: write {key}{more} into campaign.toml, then: hannes check campaign.toml"


def _named(files: Sequence[str]) -> str:
    more = len(files) - FEW
    return ", ".join(files[:FEW]) + (f" and {more} more" if more > 0 else "")


def _command(verb: str, *arguments: str) -> str:
    """A command as it is typed; of many arguments the first and an ellipsis."""
    shown = shlex.join(arguments[:FEW]) + (" ..." if len(arguments) > FEW else "")
    return f"hannes {verb} {shown}"
