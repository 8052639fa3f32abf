"""How results say which verb wrote them, so that nothing else is ever taken for one.

A folder has a marker that lists its files with their SHA-256; HDF5 files say by their schema what
they are; a CSV, which has no room for that, has a file of JSON beside it. Results of earlier
versions are known by the names that their marker lists, or by what stands beside them.
"""

import hashlib
import json
import os
import re
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hannes.core.errors import BadInput
from hannes.core.io.bounded import blocks, read_bytes
from hannes.core.io.inputs import unnoted
from hannes.core.io.json_text import parsed
from hannes.core.io.limits import MIB

MARKER = ".hannes-results"
CONVERTED, BESIDE = ".conversion.json", ".hannes.json"  # after a CSV's name: convert's, others'
# Verbs of folders of earlier versions, by a file that only they have.
FILES_OF_FORMER_VERBS = {
    "verdict.json": "diagnose",
    "calibration.json": "calibrate",
    "evaluation.json": "evaluate",
    "index.html": "reproduce",
    "summary.json": "run",
}
SCHEMAS = {b"hannes-dataset-": "dataset", b"hannes-recogniser-": "train"}
# What a damaged file is known by: its schema, or a column that only data sets have.
REMAINS = {**SCHEMAS, b"noise_seed": "dataset"}
VIEW = "hannes view"
# What files of other kinds begin with where hannes wrote them, and by which verb.
SIGNS = {
    ".html": (VIEW.encode(), "view"),
    ".svg": (VIEW.encode(), "view"),
    ".png": (VIEW.encode(), "view"),
    ".mat": (b"written by hannes", "export"),
    ".mcap": (b"hannes", "export"),
    ".c": (b"Written by `hannes export-c`", "export-c"),
}
MOST_MARK = 64 * MIB  # of a mark: a line for each of half a million files
_WORD = re.compile(r"[a-z][a-z-]{0,30}")
_HEAD = 1 << 22  # bytes in which that is looked for


@dataclass(frozen=True)
class Mark:
    """Verb that wrote a folder of results (None: not known), its files and their digests.

    A file of an earlier version has the digest "", a folder of that version stands for its files.
    """

    verb: str | None
    files: Mapping[str, str]

    def lists(self, name: str) -> bool:
        """Whether a file, or the folder of an earlier version that it lies in, is listed."""
        parents = (str(each) for each in Path(name).parents)
        return name in self.files or any(self.files.get(each) == "" for each in parents)


def folder_mark(folder: Path) -> Mark | None:
    """The mark of a folder of results, None where it has none."""
    content = _content(folder / MARKER)
    if isinstance(content, list):
        names = {str(name): "" for name in content}
        return Mark(
            next((verb for file, verb in FILES_OF_FORMER_VERBS.items() if file in names), None),
            names,
        )
    if isinstance(content, dict) and isinstance(content.get("files"), dict):
        return Mark(
            _verb(content.get("verb")) or "", {str(k): str(v) for k, v in content["files"].items()}
        )
    return None


def mark_folder(folder: Path, verb: str) -> None:
    """Mark a folder of fresh results, all of them by one verb."""
    files = {name: digest(folder / name) for name in files_below(folder)}
    content = json.dumps({"verb": verb, "files": files}, indent=0, sort_keys=True)
    (folder / MARKER).write_text(content + "\n", encoding="utf-8")


def files_below(folder: Path) -> list[str]:
    """Files and links below a folder, by their place in it; an empty folder counts as one."""
    found = []
    for place, folders, files in os.walk(folder):
        links = [name for name in folders if os.path.islink(os.path.join(place, name))]
        names = [*files, *links] or ([] if folders or place == str(folder) else [""])
        found += [Path(place, name).relative_to(folder).as_posix() for name in names]
    return sorted(found)


def digest(path: Path) -> str:
    """SHA-256 of a file; of a link's target's name; of nothing for a folder."""
    if path.is_symlink():
        return hashlib.sha256(os.readlink(path).encode()).hexdigest()
    if not path.is_file():
        return hashlib.sha256().hexdigest()
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def foreign(folder: Path, mark: Mark) -> list[str]:
    """Files in a folder of results that are not its results, by their place in it."""
    return [name for name in files_below(folder) if name != MARKER and not mark.lists(name)]


def changed(folder: Path, mark: Mark) -> list[str]:
    """Results that somebody has changed since they were written."""
    return [
        name
        for name, known in mark.files.items()
        if known and os.path.lexists(folder / name) and digest(folder / name) != known
    ]


def file_verb(path: Path) -> str | None:
    """Verb that wrote a file, None where hannes did not."""
    name = path.name.lower()
    with suppress(OSError):
        if name.endswith((".h5", ".hdf5")):
            return _hdf5_verb(path)
        if name.endswith((".csv", ".csv.gz")):
            return _csv_verb(path)
        if name.endswith(".fmu"):
            return _fmu_verb(path)
        if path.suffix.lower() in SIGNS:
            return _signed_verb(path)
        if name.endswith((CONVERTED, BESIDE)):
            return _beside_verb(path)
    return None


def beside(path: Path, verb: str) -> Path:
    """The file beside a CSV that says which verb wrote it."""
    return path.with_name(path.name + (CONVERTED if verb == "convert" else BESIDE))


def _verb(given: Any) -> str | None:
    """A verb that a file names, None where it is no word: anybody may have written it."""
    return given if isinstance(given, str) and _WORD.fullmatch(given) else None


def _fmu_verb(path: Path) -> str | None:
    """An FMU is a zip archive; hannes' has a script of this name in it."""
    import zipfile

    try:
        with zipfile.ZipFile(path) as archive:
            names = archive.namelist()
    except Exception:  # a damaged file raises nearly anything from inside the library
        return None
    return "fmu" if any(name.endswith("hannes_fmu.py") for name in names) else None


def _signed_verb(path: Path) -> str | None:
    sign, verb = SIGNS[path.suffix.lower()]
    with path.open("rb") as file:
        return verb if sign in file.read(2048) else None


def _hdf5_verb(path: Path) -> str | None:
    import h5py

    from hannes.core.recording.hdf5 import text_attribute

    with path.open("rb") as file:
        head = file.read(_HEAD)
    if head[:4] != b"\x89HDF":
        return None
    try:
        with h5py.File(path, "r") as found:
            if "schema" not in found.attrs:
                return None
            schema = text_attribute(found, "schema")
            if schema.startswith("hannes-recording-"):
                return _recording_verb(found)
    except Exception:  # a damaged file raises nearly anything from inside the library
        schema = ""
    known = (verb for start, verb in SCHEMAS.items() if schema.encode().startswith(start))
    damaged = (verb for sign, verb in REMAINS.items() if not schema and sign in head)
    return next(known, next(damaged, None))


def _recording_verb(file: Any) -> str | None:
    """A recording says which verb wrote it.

    Without that it is of `convert` where it says how it was converted, of `dataset` if simulated.
    """
    from hannes.core.recording.hdf5 import text_attribute

    if "written_by" in file.attrs:
        return _verb(text_attribute(file, "written_by"))
    if "conversion" in file.attrs and text_attribute(file, "conversion"):
        return "convert"
    simulated = "source" in file.attrs and text_attribute(file, "source") == "simulated"
    return "dataset" if simulated else None


def _csv_verb(path: Path) -> str | None:
    for end in (CONVERTED, BESIDE):
        content = _beside(path.with_name(path.name + end))
        if content is None:
            continue
        if "sha256" in content:
            if digest(path) in content["sha256"]:
                return _verb(content.get("verb"))
        elif end == CONVERTED and content.get("samples", -1) == _rows(path) >= 0:
            return "convert"  # of an earlier version
    return None


def _beside_verb(path: Path) -> str | None:
    """Verb of a file that stands beside a CSV."""
    content = _beside(path)
    if content is None:
        return None
    return _verb(content.get("verb", "convert"))


def _beside(path: Path) -> dict[str, Any] | None:
    """What a file beside a CSV says, None where it is none of hannes'."""
    content = _content(path)
    ours = isinstance(content, dict) and isinstance(content.get("sha256", []), list)
    known = ours and (
        {"verb", "sha256"} <= content.keys() or {"samples", "channels"} <= content.keys()
    )
    return content if known else None


def _rows(path: Path) -> int:
    """Rows below the header of a CSV; -1 where it cannot be read within its limits."""
    count, last = -1, b"\n"
    with suppress(BadInput), unnoted():
        for block in blocks(path):
            count, last = count + block.count(b"\n"), block
        return count + (not last.endswith(b"\n"))
    return -1


def _content(path: Path) -> Any:
    """What a mark says, None where it is none: a folder of results may be anybody's."""
    try:
        with unnoted():
            return parsed(read_bytes(path, most=MOST_MARK))
    except (BadInput, ValueError):
        return None
