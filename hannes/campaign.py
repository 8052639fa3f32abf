"""Reads a campaign: which recordings, of which plant, under which conditions, in which role."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from hannes import library, measured
from hannes.axis_record import load as load_mat
from hannes.catalogue import effect, effects
from hannes.effect import Effect
from hannes.errors import BadInput, MissingRecording, nearest
from hannes.plant import Plant, find_plant
from hannes.plant_file import read_toml, with_plant_file
from hannes.recording import Recording

KEYS = ("title", "plant", "base", "out", "effects", "recording")
RECORDING_KEYS = ("file", "experiment", "condition", "role")
ROLES = ("fit", "select", "show")
MEASURED = "measured:"  # file = "measured:emps/DATA_EMPS.mat": see hannes/measured.py


@dataclass(frozen=True)
class Entry:
    """One recording of a campaign; entries of one `condition` are repeats."""

    name: str
    recording: Recording
    condition: str
    role: str = ""


@dataclass(frozen=True)
class Campaign:
    """A plant at its given values, recordings with roles, and the effects that may be named.

    `effects` maps the name by which an effect can be found again to the effect.
    """

    plant: Plant
    shipped: Plant
    entries: tuple[Entry, ...]
    out: Path
    effects: Mapping[str, Effect]
    title: str = ""

    def of(self, *roles: str) -> tuple[Entry, ...]:
        """Entries in any of these roles."""
        return tuple(each for each in self.entries if each.role in roles)


def read_campaign(path: str | Path, seed: int = 0) -> Campaign:
    """Read a campaign (a TOML file, or a shipped name) and its recordings.

    Absent roles are drawn with `seed`.

    Raises BadInput with one line for whatever cannot be used.
    """
    path = campaign_file(path)
    content = read_toml(path)
    try:
        return _campaign(content, path, seed)
    except MissingRecording:
        raise
    except BadInput as error:
        raise BadInput(f"{path}: {error}") from None


def campaign_file(name: str | Path) -> Path:
    """Return the file of a campaign: a shipped name such as `emps`, or the path of a .toml file."""
    shipped = {path.stem: path for path in (library.folder() / "campaigns").glob("*.toml")}
    if Path(name).suffix == ".toml" or Path(name).exists():
        return Path(name)
    if str(name) not in shipped:
        raise BadInput(
            f'no campaign named "{name}"{nearest(str(name), shipped)} '
            f"(shipped: {', '.join(sorted(shipped))}; or give the path of a .toml file)"
        )
    return shipped[str(name)]


def _campaign(content: dict[str, Any], path: Path, seed: int) -> Campaign:
    _check_keys(content, KEYS, "")
    folder = path.parent
    shipped = find_plant(_text(content, "plant", "hand"), folder)
    base = _text(content, "base", "")
    plant = with_plant_file(shipped, _existing(folder / base)) if base else shipped
    rows = content.get("recording", [])
    if not isinstance(rows, list) or not rows or not all(isinstance(row, dict) for row in rows):
        raise BadInput("no [[recording]]: a campaign needs at least one, with file = ...")
    entries = [entry for row in rows for entry in _entries(row, folder, plant)]
    out = Path(_text(content, "out", f"results/{path.stem}"))  # in the current folder
    return Campaign(
        plant,
        shipped,
        with_roles(entries, seed),
        out,
        _effects(content, folder),
        _text(content, "title", path.stem),
    )


def _check_keys(table: Mapping[str, Any], known: tuple[str, ...], where: str) -> None:
    for key in table:
        if key not in known:
            raise BadInput(f'{where}unknown key "{key}"{nearest(key, known)}')


def _text(table: Mapping[str, Any], key: str, default: str) -> str:
    value = table.get(key, default)
    if not isinstance(value, str):
        raise BadInput(f"{key} = {value!r:.40}: expected text in quotes")
    return value


def _existing(path: Path) -> Path:
    if path.is_file():
        return path
    if path.is_dir():
        raise BadInput(f"{path} is a folder; expected a file, or a glob such as {path.name}/*.csv")
    near = nearest(path.name, [each.name for each in path.parent.glob("*")])
    raise BadInput(f"there is no file {path}{near}")


def _effects(content: Mapping[str, Any], folder: Path) -> dict[str, Effect]:
    own = content.get("effects", [])
    if not isinstance(own, list) or not all(isinstance(name, str) for name in own):
        raise BadInput('effects: expected a list, such as ["mine.py:EFFECT"]')
    found = {_rooted(name, folder): effect(name, folder) for name in own}
    return {**effects(), **found}


def _rooted(name: str, folder: Path) -> str:
    """A user's effect as it can be found from anywhere: a verdict may be written elsewhere."""
    return str((folder / name).resolve()) if ".py:" in name else name


def _entries(row: Mapping[str, Any], folder: Path, plant: Plant) -> list[Entry]:
    name = _text(row, "file", "")
    if not name:
        raise BadInput("a [[recording]] lacks file = ...")
    _check_keys(row, RECORDING_KEYS, f"recording {name}: ")
    role = _text(row, "role", "")
    if role and role not in ROLES:
        raise BadInput(
            f'recording {name}: role = "{role}"{nearest(role, ROLES)}; one of {", ".join(ROLES)}'
        )
    experiment = _text(row, "experiment", "")
    condition = _text(row, "condition", experiment)
    made = []
    for path in _paths(name, folder):
        recording = _checked(_read(path), plant, path)
        if experiment:
            text = _experiment_text(experiment, folder)
            recording = replace(recording, experiment=text)
        made.append(Entry(path.name, recording, condition or path.name, role))
    return made


def _paths(name: str, folder: Path) -> list[Path]:
    if name.startswith(MEASURED):
        group, _, file = name.removeprefix(MEASURED).partition("/")
        return [_existing(measured.folder(group) / file)]
    if not any(sign in name for sign in "*?["):
        return [_existing(folder / name)]
    root = Path(name).anchor
    found = sorted(Path(root or folder).glob(name.removeprefix(root)))
    if not found:
        raise BadInput(f'no file matches "{name}" in {folder}')
    return found


def _read(path: Path) -> Recording:
    return load_mat(path) if path.suffix == ".mat" else Recording.read(path)


def _checked(recording: Recording, plant: Plant, path: Path) -> Recording:
    if recording.plant and recording.plant != plant.name:
        raise BadInput(
            f'{path.name} is a recording of the plant "{recording.plant}", not of "{plant.name}"; '
            "choose the campaign's plant to match"
        )
    try:
        recording.expect(plant.channels, plant.required, f"the plant {plant.name}")
    except BadInput as error:
        raise BadInput(f"{path.name}: {error}") from None
    if not any(name in recording for name in plant.judged):
        raise BadInput(f"{path.name} has none of the channels {', '.join(plant.judged)} to compare")
    return recording


def _experiment_text(name: str, folder: Path) -> str:
    """Text of an experiment by name, or of a file relative to the campaign."""
    from hannes.experiment_file import experiment_text

    return experiment_text(name, folder)


def with_roles(entries: list[Entry], seed: int) -> tuple[Entry, ...]:
    """Give a role to entries that lack one: per condition, a quarter each to select and show.

    Conditions with fewer than three recordings are drawn from together.
    """
    rng = np.random.default_rng([seed, len(entries)])
    conditions: dict[str, list[int]] = {}
    for place, entry in enumerate(entries):
        if not entry.role:
            conditions.setdefault(entry.condition, []).append(place)
    groups = [places for places in conditions.values() if len(places) >= 3]
    groups.append([p for places in conditions.values() if len(places) < 3 for p in places])
    roles = {}
    for group in groups:
        drawn = rng.permutation(group)
        for place, role in zip(drawn, _shares(len(group)), strict=True):
            roles[int(place)] = role
    return tuple(
        replace(entry, role=roles.get(place, entry.role)) for place, entry in enumerate(entries)
    )


def _shares(count: int) -> list[str]:
    if count < 3:
        return ["fit", "show"][:count]
    aside = max(1, round(count / 4))
    return ["select"] * aside + ["show"] * aside + ["fit"] * (count - 2 * aside)
