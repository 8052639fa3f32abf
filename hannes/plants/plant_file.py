"""hand.toml of any plant: which plant it is for, reading it onto that plant, writing it."""

from pathlib import Path

from hannes.core.errors import BadInput
from hannes.plants.protocol import Plant, find_plant
from hannes.simulation.hand import hand_file
from hannes.simulation.hand.hand import Hand

BASES = {"hand": "hannes"}  # other plants go by the name under which a campaign finds them


def base_name(name: str) -> str:
    """Return the `base` of a hand.toml of the plant that campaigns know as `name`."""
    return BASES.get(name, name)


def load_model(name: str) -> Hand | Plant:
    """Return a hand, or the plant that a hand.toml is for, at its values.

    Raises BadInput for a file that cannot be used. A user's own plant is looked for in the
    current folder, too.
    """
    if not name.endswith(".toml"):
        return hand_file.load_hand(name)
    root = hand_file.chain(Path(name))[-1]
    base = root.text("base", "hannes")
    if base in hand_file.SHIPPED:
        return hand_file.load_hand(name)
    try:
        plant = find_plant(base, Path.cwd())
    except BadInput as error:
        root.refuse("base", f'= "{base}": {error}')
    return with_plant_file(plant, Path(name), base)


def with_plant_file(plant: Plant, path: Path, base: str) -> Plant:
    """Return `plant`, known as `base`, with the effects and values of a hand.toml; else BadInput.

    The file may build on other such files.
    """
    return hand_file.load(path.name, path.parent, {base: lambda: plant})


def plant_toml(plant: Plant, shipped: Plant, base: str) -> str:
    """Text of a hand.toml that makes `plant` from `shipped`, known as `base`."""
    return hand_file.hand_toml(plant, shipped, base)
