"""Reads a campaign: which recordings, of which plant, under which conditions, in which role."""

import os
import re
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path

from hannes.campaigns import third_party
from hannes.campaigns.campaign import Campaign, Entry
from hannes.campaigns.foreign.mapping import ColumnMap
from hannes.campaigns.foreign.mapping_file import read_mapping
from hannes.campaigns.mapped_runs import mapped_runs
from hannes.campaigns.one_grid import on_one_grid
from hannes.campaigns.roles import with_roles
from hannes.campaigns.undeclared import undeclared, without
from hannes.core.effect import Effect, joined
from hannes.core.errors import BadInput, NotTrusted, nearest
from hannes.core.io.file_patterns import is_pattern, matching
from hannes.core.io.inputs import is_file, note, noted
from hannes.core.io.toml_table import Table, read_text
from hannes.core.ranged import own_ranges, ranged, ranges_of_nothing
from hannes.core.recording.recording import Recording
from hannes.core.trust.consent import consenting
from hannes.plants.plant_file import base_name, with_plant_file
from hannes.plants.protocol import Plant, find_plant, require_usable
from hannes.simulation.catalogue import descriptions, effect, effects
from hannes.simulation.experiment import shipped as library
from hannes.simulation.hand.hand_file import own_catalogue

KEYS = ("title", "plant", "base", "out", "effects", "recording", "calibrate", "diagnose")
RECORDING_KEYS = ("file", "mapping", "runs", "experiment", "condition", "role", "unit")
ROLES = ("fit", "select", "show")
MEASURED = "measured:"  # file = "measured:emps/DATA_EMPS.mat": see hannes/campaigns/third_party.py
SIMULATED = "simulated:"  # file = "simulated:mine.toml": see virtual_recordings.py
_SLICE = re.compile(r"(\d{0,9}):(\d{0,9})(?::(\d{0,9}))?")


def read_campaign(
    path: str | Path,
    seed: int = 0,
    *,
    plant: Plant | None = None,
    effects: Iterable[Effect] = (),
    trust: bool = False,
) -> Campaign:
    """Read a campaign (a TOML file, or a shipped name) and its recordings.

    Absent roles are assigned with `seed`. `plant` stands for the one that the file names, `effects`
    join those that it names; `trust`: Python that it names may run. Raises BadInput with one line
    for whatever cannot be used: nothing is computed before every recording is checked.
    """
    if seed < 0:
        raise BadInput(f"seed = {seed}: expected 0 or more")
    path = campaign_file(path)
    with noted() as inputs, consenting(trust):
        root = Table.parse(read_text(path), str(path), KEYS)
        made = _campaign(root, path, seed, plant, {each.name: each for each in effects})
        return replace(made, inputs=frozenset(inputs))


def shipped_campaigns() -> dict[str, Path]:
    """Files of the shipped campaigns by name, in alphabetical order."""
    return {path.stem: path for path in sorted((library.folder() / "campaigns").glob("*.toml"))}


def campaign_file(name: str | Path) -> Path:
    """Return the file of a campaign: a shipped name such as `emps`, or the path of a .toml file."""
    shipped = shipped_campaigns()
    if Path(name).suffix == ".toml" or Path(name).exists():
        return Path(name)
    if str(name) not in shipped:
        raise BadInput(
            f'no campaign named "{name}"{nearest(str(name), shipped)} '
            f"(shipped: {', '.join(sorted(shipped))}; or give the path of a .toml file)"
        )
    return shipped[str(name)]


def _campaign(
    root: Table, path: Path, seed: int, plant: Plant | None, own: Mapping[str, Effect]
) -> Campaign:
    folder, name = path.parent, root.text("plant", "hand")
    shipped = plant or _plant(root, name, path)
    plant = _at_base(root, shipped, base_name(name), folder)
    rows = root.items("recording")
    if not rows or not all(isinstance(row, dict) for row in rows):
        root.refuse("recording", "is missing: expected [[recording]] with file = ... below")
    found = [
        one
        for number, row in enumerate(rows, 1)
        for one in _entries(
            Table(row, root.where, RECORDING_KEYS, f"recording {number}."), folder, plant
        )
    ]
    return Campaign(
        plant,
        shipped,
        with_roles(on_one_grid(plant, _with_distinct_names(root, found)), seed),
        Path(root.text("out", f"results/{path.stem}")),  # in the current folder
        _effects(root, path, plant, own),
        root.text("title", path.stem),
        base_name(name),
        root.table("calibrate"),
        root.table("diagnose"),
    )


def _with_distinct_names(root: Table, found: list[tuple[Path, str, Entry]]) -> list[Entry]:
    """Entries with distinct names; BadInput where one is listed twice: its copy could be fitted."""
    seen, names = set(), Counter(each.name for _, _, each in found)
    for path, run, each in found:
        if (key := (path.resolve(), run)) in seen:
            root.refuse("recording", f'lists "{each.name}" twice: leave it out of one of them')
        seen.add(key)
    return [
        replace(each, name=f"{path}, {each.name}") if names[each.name] > 1 else each
        for path, _, each in found
    ]


def _plant(root: Table, name: str, path: Path) -> Plant:
    try:
        return find_plant(name, path.parent, path)
    except BadInput as error:
        root.refuse("plant", f'= "{name}": {error}')


def _at_base(root: Table, plant: Plant, base: str, folder: Path) -> Plant:
    """The plant at the values of the campaign's `base`, a hand.toml; unchanged without one."""
    file = root.text("base", "")
    return with_plant_file(plant, _existing(root, "base", folder / file), base) if file else plant


def _existing(table: Table, key: str, path: Path) -> Path:
    if is_file(path):
        return path
    if os.path.isdir(path):
        table.refuse(
            key, f"= {path}: a folder; expected a file, or a glob such as {path.name}/*.csv"
        )
    beside = os.listdir(path.parent) if os.path.isdir(path.parent) else []
    table.refuse(key, f"= {path}: there is no such file{nearest(path.name, beside)}")


def _effects(
    root: Table, path: Path, plant: Plant, given: Mapping[str, Effect]
) -> dict[str, Effect]:
    own = dict(given)
    for name in root.texts("effects"):
        if name in descriptions():
            advice = "leave it out; `hannes diagnose --describe` fits it where it is needed"
            root.refuse("effects", f'"{name}" describes and names no cause: {advice}')
        try:
            mine = effect(name, path.parent, path)
            known = {**effects(), **own_catalogue(plant), **own}
            taken = known.get(mine.name, mine) is not mine
            own[str((path.parent / name).resolve()) if taken else mine.name] = mine
        except BadInput as error:
            root.refuse("effects", f"cannot be used: {error}")
    found = {**effects(), **own_catalogue(plant), **own}
    if strange := ranges_of_nothing(plant, found.values()):
        root.refuse("plant", f"cannot be used: {strange}")
    found = {name: ranged(each, own_ranges(plant)) for name, each in found.items()}
    try:
        joined((), found.values())
    except BadInput as error:
        root.refuse("effects", f"cannot be used: {error}")
    return found


def _entries(row: Table, folder: Path, plant: Plant) -> list[tuple[Path, str, Entry]]:
    """Files, runs in them, entries of one [[recording]], each checked against `plant`."""
    row.require("file", '"void_01.csv"')
    name, experiment = row.text("file", ""), row.text("experiment", "")
    role = row.choice("role", ROLES) if "role" in row else ""
    condition, unit = row.text("condition", experiment), row.text("unit", "")
    planned = _experiment_text(row, experiment, folder) if experiment else None
    made = []
    for path, run, recording in _recordings(row, name, folder, plant):
        if planned is not None:
            recording = replace(recording, experiment=planned)
        left_out = undeclared(recording, plant)
        recording = without(recording, left_out)
        _check(recording, plant, path)
        place = _place(path, folder)
        name = place if run == path.name else run
        entry = Entry(name, recording, condition or place, role, unit=unit, left_out=left_out)
        made.append((path, run, entry))
    return made


def _recordings(
    row: Table, name: str, folder: Path, plant: Plant
) -> list[tuple[Path, str, Recording]]:
    """Files, names of runs, recordings: read, or simulated here."""
    if not name.startswith(SIMULATED):
        wanted, paths, mapping = _wanted(row), _paths(row, name, folder), _mapping(row, folder)
        found = [(path, list(read_runs(path, plant, mapping).items())[wanted]) for path in paths]
        if not any(runs for _, runs in found):
            row.refuse("runs", f'= "{row.text("runs", ":"):.40}": selects no run of these files')
        return [(path, run, recording) for path, runs in found for run, recording in runs]
    from hannes.simulation.virtual_recordings import virtual_recordings

    if "mapping" in row:
        row.refuse("mapping", "is for a raw log, and this recording is simulated: leave it out")
    experiment = name.removeprefix(SIMULATED)
    place = folder / experiment if experiment.endswith(".toml") else experiment
    try:
        return [(Path(file), file, each) for file, each in virtual_recordings(place).items()]
    except BadInput as error:
        row.refuse("file", f"cannot be simulated: {error}")


def _place(path: Path, folder: Path) -> str:
    """A file's path within the campaign's folder, its name where it is elsewhere."""
    return path.relative_to(folder).as_posix() if path.is_relative_to(folder) else path.name


def _wanted(row: Table) -> slice:
    """Which runs of each file: `runs = "1::5"` is every fifth from the second, as Python slices."""
    text = row.text("runs", ":")
    found = _SLICE.fullmatch(text)
    if not found or (found[3] and int(found[3]) == 0):
        row.refuse(
            "runs", f'= "{text:.40}": expected start:stop:step, counted from 0, such as "1::5"'
        )
    return slice(*(int(part) if part else None for part in found.groups()))


def _mapping(row: Table, folder: Path) -> ColumnMap | None:
    """What the recordings are read through: a mapping beside the campaign, or a shipped one."""
    if "mapping" not in row:
        return None
    name = row.text("mapping", "")
    try:
        return read_mapping(folder / name if name.endswith(".toml") else name)
    except NotTrusted:
        raise
    except BadInput as error:
        row.refuse("mapping", f"cannot be used: {error}")


def read_runs(path: Path, plant: Plant, mapping: ColumnMap | None = None) -> dict[str, Recording]:
    """Return the recordings of one file by name; BadInput where it cannot be read.

    Most files hold one recording; a raw log has as many as its `mapping` says, and a plant's own
    logger may write several runs into one.
    """
    note(path)
    if mapping is not None:
        return mapped_runs(path, mapping)
    read = getattr(plant, "read", None)
    return read(path) if read is not None else {path.name: Recording.read(path)}


def _paths(row: Table, name: str, folder: Path) -> list[Path]:
    if name.startswith(MEASURED):
        group, _, name = name.removeprefix(MEASURED).partition("/")
        folder = third_party.folder(group)
    if not is_pattern(name):
        return [_existing(row, "file", folder / name)]
    try:
        found = matching(name, folder)
    except BadInput as error:
        row.refuse("file", f"cannot be used: {error}")
    if not found:
        row.refuse("file", f'= "{name}" matches no file in {folder}')
    return found


def _check(recording: Recording, plant: Plant, path: Path) -> None:
    """Raise BadInput, naming the file, unless `plant` can be driven and judged by `recording`."""
    if recording.plant and recording.plant != plant.name:
        raise BadInput(
            f'{path}: a recording of the plant "{recording.plant}", not of "{plant.name}"; '
            "choose the campaign's plant to match"
        )
    try:
        recording.expect(plant.channels, plant.required, f"the plant {plant.name}")
        require_usable(plant, recording)
    except BadInput as error:
        raise BadInput(f"{path}: {error}") from None
    if not any(name in recording for name in plant.judged):
        raise BadInput(f"{path}: has none of the channels {', '.join(plant.judged)} to compare")


def _experiment_text(row: Table, name: str, folder: Path) -> str:
    """Text of an experiment by name, or of a file relative to the campaign."""
    from hannes.simulation.experiment.reader import experiment_text

    try:
        return experiment_text(name, folder)
    except BadInput as error:
        row.refuse("experiment", f"cannot be used: {error}")
