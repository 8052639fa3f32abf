"""Recordings as results of a verb: HDF5 says by itself what it is, a CSV by a file beside it."""

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from hannes.core.io import atomic_files
from hannes.core.io.result_marks import beside, digest
from hannes.core.recording import csv, hdf5
from hannes.core.recording.recording import Recording, is_csv


def results_at(path: str | Path, verb: str) -> list[Path]:
    """Files that `write_marked` writes for a recording at `path`."""
    return [Path(path), beside(Path(path), verb)] if is_csv(path) else [Path(path)]


def write_marked(
    recording: Recording, path: str | Path, verb: str, report: Mapping[str, Any] | None = None
) -> None:
    """Write a recording that `verb` made, and beside a CSV the verb, its digest and the `report`.

    What stands beside is written first, with the digest of the CSV that is replaced, too: a command
    killed in between leaves a CSV that is known, old or new.
    """
    if not is_csv(path):
        _write_hdf5(recording, path, verb)
        return
    data = csv.dump(recording.channels, recording.units, str(path).lower().endswith(".gz"))
    digests = [hashlib.sha256(data).hexdigest()]
    if Path(path).is_file():
        digests.append(digest(Path(path)))
    content = {**(report or {}), "verb": verb, "sha256": digests}
    text = json.dumps(content, indent=1, ensure_ascii=False, allow_nan=False) + "\n"
    atomic_files.write_text(beside(Path(path), verb), text)
    atomic_files.write_bytes(path, data)


def _write_hdf5(recording: Recording, path: str | Path, verb: str) -> None:
    """Write HDF5, with the verb where the recording does not carry it itself."""
    if verb in ("convert", "dataset"):
        recording.to_hdf5(path)
        return
    metadata = recording.metadata() | {"written_by": verb}
    atomic_files.write_bytes(path, hdf5.dump(recording.channels, recording.units, metadata))
