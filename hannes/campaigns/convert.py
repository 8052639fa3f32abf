"""`hannes convert`: foreign files through a mapping into recordings, with a report of each."""

import json
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from hannes.campaigns.foreign.align import Shift, aligned
from hannes.campaigns.foreign.mapping import ColumnMap
from hannes.campaigns.foreign.mapping_file import read_mapping
from hannes.campaigns.foreign.to_recordings import Run, read_runs
from hannes.core.errors import BadInput
from hannes.core.io.outputs import reserved
from hannes.core.recording.marked import results_at, write_marked
from hannes.core.recording.recording import SUFFIXES, Recording


@dataclass(frozen=True)
class Converted:
    """A recording made from a foreign file, with a report of the conversion."""

    recording: Recording
    file: Path
    number: int  # of the run within its file, from 1; 0 where the file is one run
    report: dict[str, Any]

    @property
    def name(self) -> str:
        """Name for a file of it: that of the foreign file, with the run's number."""
        stem = self.file.name.split(".")[0]
        return f"{stem}-{self.number:03d}" if self.number else stem


def convert(
    paths: Sequence[str | Path], mapping: ColumnMap | str | Path, *, trust: bool = False
) -> list[Converted]:
    """Read foreign files through a mapping (or its TOML file); one recording for each run.

    `trust`: Python that the mapping's file names may run. Raises BadInput with one line, naming
    file and line or the mapping's key, for whatever cannot be used; ComputationFailed where the
    simulation that a run is aligned with fails.
    """
    if not isinstance(mapping, ColumnMap):
        mapping = read_mapping(mapping, trust=trust)
    from hannes.core.io.progress import progress_bar

    found = []
    bar = progress_bar(
        paths, desc="converting", unit=" files", delay=2.0, disable=None, leave=False
    )
    for path in map(Path, bar):
        runs = read_runs(path, mapping)
        for number, run in enumerate(runs, start=1):
            found.append(_converted(path, number if len(runs) > 1 else 0, run, mapping))
    return found


def planned(paths: Sequence[str | Path], out: str | Path) -> list[Path]:
    """Files that `write` would make of foreign files of one run each: what can be known before."""
    if Path(out).name.lower().endswith(SUFFIXES):
        return results_at(out, "convert")
    return [Path(out) / f"{Path(each).name.split('.')[0]}.h5" for each in paths]


def write(
    converted: Sequence[Converted],
    out: str | Path,
    *,
    reads: Iterable[str | Path] = (),
    force: bool = False,
) -> list[Path]:
    """Write one recording to the file `out`, or any number into the folder `out` as HDF5.

    None is written over a foreign file that they come from, or over one of `reads`; `force`: files
    that another command wrote are replaced, too.

    Each is written whole or not at all; returns the paths. A name with a recording's suffix is a
    file, and then BadInput where there are several recordings.
    """
    out = Path(out)
    if out.name.lower().endswith(SUFFIXES):
        if len(converted) > 1:
            raise BadInput(f"{len(converted)} recordings do not fit into {out}: name a folder")
        targets = [out]
    else:
        targets = [out / f"{each.name}.h5" for each in converted]
    if twice := next((path for path in targets if targets.count(path) > 1), None):
        raise BadInput(f"two files would become {twice}: convert them into different folders")
    inputs = [*reads, *(each.file for each in converted)]
    results = [each for target in targets for each in results_at(target, "convert")]
    with reserved("convert", results, inputs, force=force):
        for each, target in zip(converted, targets, strict=True):
            write_marked(each.recording, target, "convert", each.report)
    return targets


def _converted(path: Path, number: int, run: Run, mapping: ColumnMap) -> Converted:
    plant = mapping.plant
    try:
        recording = Recording(
            {"time": run.time, **run.channels},
            {"time": "s", **{name: plant.channels[name] for name in run.channels}},
            plant=plant.name,
            experiment=mapping.experiment,
        ).expect(plant.channels, plant.required, f"the plant {plant.name}")
        recording, shift = aligned(recording, mapping)
    except BadInput as error:
        raise BadInput(f"{path}{f', run {number}' if number else ''}: {error}") from None
    report = _report(path, run, mapping, recording, shift)
    text = json.dumps(report, ensure_ascii=False, allow_nan=False)
    return Converted(replace(recording, conversion=text), path, number, report)


def _report(
    path: Path, run: Run, mapping: ColumnMap, recording: Recording, shift: Shift | None
) -> dict[str, Any]:
    """Report of a conversion, as plain data; rates in Hz, times in s."""
    intervals = np.diff(recording.time)
    return {
        "file": path.name,
        "rows": [int(run.rows[0]) + 1, int(run.rows[-1]) + 1],
        "samples": len(recording),
        "span": {"t0": float(recording.time[0]), "t1": float(recording.time[-1]), "unit": "s"},
        "interval": {
            "median": float(np.median(intervals)),
            "shortest": float(intervals.min()),
            "longest": float(intervals.max()),
            "unit": "s",
        },
        "resampled_Hz": mapping.time.resample or None,
        "cut_s": [list(pair) for pair in mapping.time.cut],
        "missing": list(mapping.missing),
        "dropped_rows": run.dropped,
        "disordered_rows": run.disordered,
        "filled_values": dict(run.filled),
        "channels": {
            name: {
                "column": rule.column.name if rule.column else None,
                "unit": recording.units[name],
                "factor": rule.factor,
                "offset": rule.offset,
                "stated": dict(rule.stated),
            }
            for name, rule in mapping.channels.items()
        },
        "time_offset": {"value": mapping.time.offset, "unit": "s"},
        "shift": shift.as_dict() if shift else None,
    }
