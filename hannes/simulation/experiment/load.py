"""Experiments from TOML: `load_experiment("dynamometer")` gives the simulations it asks for."""

from pathlib import Path

from hannes.core.errors import BadInput
from hannes.core.io.toml_table import Table, read_text
from hannes.core.trust.consent import consenting
from hannes.simulation.experiment import shipped
from hannes.simulation.experiment.clearance import require_clear
from hannes.simulation.experiment.friction_curve import FrictionCurve
from hannes.simulation.experiment.reader import COMMON, KEYS, read_experiment
from hannes.simulation.experiment.variants import Variant, expanded
from hannes.simulation.hand.hand import Hand
from hannes.simulation.hand.hand_file import changed, load_hand

KINDS = {"grasp": KEYS, "friction-curve": (*COMMON, "joint_speed", "cart_speed")}


def load(name: str | Path, *, trust: bool = False) -> list[Variant] | FrictionCurve:
    """Return what an experiment, shipped or from a .toml file, asks for; BadInput otherwise.

    `trust`: Python that the file names may run.
    """
    path = shipped.find(name)
    where = str(path) if str(name).endswith(".toml") else path.name
    with consenting(trust):
        return read(read_text(path), where, path.parent)


def load_experiment(name: str | Path, *, trust: bool = False) -> list[Variant]:
    """Return the simulations of an experiment, shipped or from a .toml file, at least one.

    `trust`: Python that the file names may run.
    """
    found = load(name, trust=trust)
    if isinstance(found, FrictionCurve):
        raise BadInput(f"{name}: needs no simulation; see it with `hannes run {name}`")
    return found


def read(text: str, where: str, folder: Path | None = None) -> list[Variant] | FrictionCurve:
    """Return what a TOML text asks for; `where` stands for the file in messages.

    Relative paths start at `folder`.
    """
    root = _root(text, where)
    hand = _hand(root, folder)
    if root.text("kind", "grasp") == "friction-curve":
        return _curve(root, hand)
    variants = expanded(hand, read_experiment(root, folder), root)
    for each in variants:
        require_clear(each.hand, each.experiment, where)
    return variants


def _root(text: str, where: str) -> Table:
    """Parse twice: the kind decides which keys are allowed."""
    anything = Table.parse(text, where, ())
    if "base" in anything and "reference" not in anything:
        anything.refuse(
            "base", 'belongs to a hand file; an experiment names it: hand = "hand.toml"'
        )
    return Table(anything.content, where, KINDS[anything.choice("kind", tuple(KINDS), "grasp")])


def _hand(root: Table, folder: Path | None) -> Hand:
    name = root.text("hand", "hannes")
    try:
        hand = load_hand(name, folder)
    except BadInput as error:
        root.refuse("hand", f'= "{name}" cannot be used: {error}')
    return changed(hand, root, folder)


def _curve(root: Table, hand: Hand) -> FrictionCurve:
    return FrictionCurve(
        root.text("title", "Friction against speed"),
        hand,
        root.quantity("joint_speed", "rad/s", "300 rpm"),
        root.quantity("cart_speed", "m/s", "50 mm/s"),
    )
