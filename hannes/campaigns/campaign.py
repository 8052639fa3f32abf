"""A campaign: recordings of one plant, each with its condition and its role."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from hannes.campaigns.earlier_runs import after, before_each
from hannes.core.effect import Effect
from hannes.core.io.toml_table import Table
from hannes.core.recording.recording import Recording
from hannes.plants.protocol import Plant


@dataclass(frozen=True)
class Entry:
    """One recording of a campaign; entries of one `condition` are repeats.

    `role` is fit, select (validation) or show (test split). `number` counts the recordings of the
    campaign from 0, in their order; `earlier` is what those before it of its unit did, see
    earlier_runs.py. `unit` names which of several machines of one kind it is of.
    `left_out` are channels of its file that the plant does not have.
    """

    name: str
    recording: Recording
    condition: str
    role: str = ""
    number: int = 0
    unit: str = ""
    left_out: tuple[str, ...] = ()
    earlier: Mapping[str, float] = field(default_factory=dict, hash=False)


def in_order(entries: Sequence[Entry]) -> tuple[Entry, ...]:
    """The entries, each with its number and what those of its unit before it did."""
    earlier: dict[int, Mapping[str, float]] = {}
    for unit in dict.fromkeys(each.unit for each in entries):
        own = [k for k, each in enumerate(entries) if each.unit == unit]
        earlier.update(zip(own, before_each([entries[k].recording for k in own]), strict=True))
    return tuple(replace(each, number=k, earlier=earlier[k]) for k, each in enumerate(entries))


def following(entries: Sequence[Entry], new: Entry) -> Entry:
    """A new entry with its number and what those before it did, where it follows all entries."""
    last = max(entries, key=lambda each: each.number)
    return replace(new, number=last.number + 1, earlier=after(last.earlier, last.recording))


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
        object.__setattr__(self, "entries", in_order(self.entries))

    def of(self, *roles: str) -> tuple[Entry, ...]:
        """Entries in any of these roles."""
        return tuple(each for each in self.entries if each.role in roles)
