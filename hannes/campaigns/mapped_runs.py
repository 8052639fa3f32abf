"""Runs of a raw log, read through a mapping where a recording is expected."""

from pathlib import Path

from hannes.campaigns.convert import convert
from hannes.campaigns.foreign.mapping import ColumnMap
from hannes.core.recording.recording import Recording


def mapped_runs(path: Path, mapping: ColumnMap) -> dict[str, Recording]:
    """Return the runs of a foreign file by name: `log.csv`, or `log.csv, run 1` where it has more.

    Raises BadInput as `convert` does.
    """
    return {
        f"{path.name}, run {each.number}" if each.number else path.name: each.recording
        for each in convert([path], mapping)
    }
