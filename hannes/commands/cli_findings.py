"""What `hannes check` and its like say of findings, as lines for a terminal."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from hannes.core.errors import printable

if TYPE_CHECKING:
    from hannes.campaigns.quality.finding import Finding


def faulty_files(found: Sequence[tuple[str, Sequence["Finding"]]]) -> list[str]:
    """Names of the files with a fault."""
    return [name for name, some in found if any(each.level == "fault" for each in some)]


def faults_listed(faulty: Sequence[str], json: bool = False) -> str:
    """Where the faults are that were printed: each is said once."""
    more = f" and {len(faulty) - 1} more" if len(faulty) > 1 else ""
    where = "findings in the JSON" if json else "faults in the list above"
    return f"{faulty[0]}{more}: not sound; see the {where}"


def finding_lines(findings: Sequence["Finding"], notes: bool) -> list[str]:
    """A line each; notes only where they are asked for."""
    return [f"  {printable(each)}" for each in findings if notes or each.level != "note"]


def finding_counts(findings: Sequence["Finding"]) -> str:
    """`1 fault, 2 warnings, 6 notes`."""
    levels = [each.level for each in findings]
    counts = {level: levels.count(level) for level in ("fault", "warning", "note")}
    return ", ".join(f"{n} {level}{'' if n == 1 else 's'}" for level, n in counts.items())
