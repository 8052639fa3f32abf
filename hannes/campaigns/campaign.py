"""A campaign: recordings of one plant, each with its condition and its role."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

from hannes.core.effect import Effect
from hannes.core.io.toml_table import Table
from hannes.core.recording.recording import Recording
from hannes.plants.protocol import Plant


@dataclass(frozen=True)
class Entry:
    """One recording of a campaign; entries of one `condition` are repeats.

    `role` is fit, select (validation) or show (test split). `number` counts the recordings of the
    campaign from 0, in their order. `unit` names which of several machines of one kind it is of.
    `left_out` are channels of its file that the plant does not have.
    """

    name: str
    recording: Recording
    condition: str
    role: str = ""
    number: int = 0
    unit: str = ""
    left_out: tuple[str, ...] = ()


@dataclass(frozen=True)
class Campaign:
    """A plant at its nominal values, recordings with roles, and the candidate effects.

    `shipped` is the plant without the campaign's `base`. `effects` maps a name to an effect: the
    name finds it again from any folder. `base` is what a hand.toml of this plant starts from.
    `calibrate` and `diagnose` are the campaign's tables of these names, not yet read. `inputs` are
    the files that it was read from, which no result may replace.
    """

    plant: Plant
    shipped: Plant
    entries: tuple[Entry, ...]
    out: Path
    effects: Mapping[str, Effect]
    title: str = ""
    base: str = "hannes"
    calibrate: Table = field(default_factory=lambda: Table({}, "campaign", ()))
    diagnose: Table = field(default_factory=lambda: Table({}, "campaign", ()))
    inputs: frozenset[Path] = field(default=frozenset(), repr=False)

    def __post_init__(self) -> None:
        numbered = (replace(each, number=k) for k, each in enumerate(self.entries))
        object.__setattr__(self, "entries", tuple(numbered))

    def of(self, *roles: str) -> tuple[Entry, ...]:
        """Entries in any of these roles."""
        return tuple(each for each in self.entries if each.role in roles)
