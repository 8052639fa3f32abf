"""hand.toml of any plant: which plant it is for, reading it onto that plant, writing it."""

from pathlib import Path

from hannes.core.errors import BadInput
from hannes.core.trust.consent import consenting
from hannes.core.trust.python_source import is_own, located
from hannes.plants.protocol import Plant, find_plant
from hannes.simulation.hand import hand_file
from hannes.simulation.hand.hand import Hand

BASES = {"hand": "hannes"}  # other plants go by the name under which a campaign finds them


def base_name(name: str) -> str:
    """Return the `base` of a hand.toml of the plant that campaigns know as `name`."""
    return BASES.get(name, name)


def load_model(name: str, *, trust: bool = False) -> Hand | Plant:
    """Return a hand, or the plant that a hand.toml is for, at its values.

    `trust`: Python that the file names may run. A user's own plant is looked for beside the file,
    then in the current folder. Raises BadInput for a file that cannot be used.
    """
    if not name.endswith(".toml"):
        return hand_file.load_hand(name)
    root = hand_file.chain(Path(name))[-1]
    base = root.text("base", "hannes")
    with consenting(trust):
        if base in hand_file.SHIPPED:
            return hand_file.load_hand(name)
        try:
            plant = find_plant(base, _home(base, Path(root.where).parent), root.where)
        except BadInput as error:
            root.refuse("base", f'= "{base}": {error}')
        return with_plant_file(plant, Path(name), base)


def _home(base: str, folder: Path) -> Path:
    """Where a plant's Python lies: beside the file that names it, or in the current folder."""
    if is_own(base) and located(base, folder).folder is None:
        return Path.cwd()
    return folder


def own_python_described(name: str) -> str:
    """What a hand.toml says that needs Python of the user's own; nothing where it needs none.

    None of it is run. Raises BadInput for a file that cannot be read.
    """
    if not name.endswith(".toml"):
        return ""
    tables = hand_file.chain(Path(name))
    effects = [each for table in tables for each in table.texts("effects")]
    base = tables[-1].text("base", "hannes")
    if not any(map(is_own, [base, *effects])):
        return ""
    values: dict[str, object] = {}
    for table in reversed(tables):
        values |= table.table("parameters").content
    lines = [f"{name}: of {base}", "  effects: " + (", ".join(effects) or "none")]
    lines += [f"  {key} = {value}" for key, value in values.items()]
    return "\n".join([*lines, "Python of its own is not run by a look: add --trust for all of it"])


def with_plant_file(plant: Plant, path: Path, base: str) -> Plant:
    """Return `plant`, known as `base`, with the effects and values of a hand.toml; else BadInput.

    The file may build on other such files.
    """
    return hand_file.load(path.name, path.parent, {base: lambda: plant})


def plant_toml(plant: Plant, shipped: Plant, base: str, folder: str | Path | None = None) -> str:
    """Text of a hand.toml that makes `plant` from `shipped`, known as `base`; see `hand_toml`."""
    return hand_file.hand_toml(plant, shipped, base, folder)
