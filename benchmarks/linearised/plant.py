"""A plant that is the hand to a diagnosis, and whose runs are sums of the truth's columns."""

from collections.abc import Mapping, Sequence

import numpy as np

from benchmarks.linearised.tangent import Shaped, Tangent, nominal, tangent
from hannes.core.effect import Effect
from hannes.core.parameter import ParameterSet
from hannes.core.recording.recording import Recording
from hannes.plants.hand.plant import HandPlant
from hannes.plants.part_fault import PartFault

Channels = dict[str, np.ndarray]
Columns = Mapping[str, np.ndarray]


class LinearHand:
    """Plant: all that a hand declares, of its parameters, effects and faults; runs are linear."""

    name = HandPlant.name
    channels = HandPlant.channels
    required = HandPlant.required
    judged = HandPlant.judged
    block = HandPlant.block
    expected = HandPlant.expected
    start_time = HandPlant.start_time
    quantities = staticmethod(HandPlant.quantities)
    generic: Mapping[str, object] = {}

    def __init__(self, hand: HandPlant | None = None) -> None:
        self.hand = hand or HandPlant()

    @property
    def parameters(self) -> ParameterSet:
        """Of base and effects, at their nominal values."""
        return self.hand.parameters

    @property
    def effects(self) -> tuple[Effect, ...]:
        """Effects in the model."""
        return self.hand.effects

    @property
    def catalogue(self) -> Mapping[str, Effect]:
        """Faults of one finger, and settings other than stated."""
        return self.hand.catalogue

    @property
    def free(self) -> Mapping[str, float]:
        """Standard deviation of what a refit fits [SI]."""
        return self.hand.free

    @property
    def run_to_run(self) -> Mapping[str, float]:
        """Run-to-run standard deviation by parameter [SI]."""
        return self.hand.run_to_run

    @property
    def uncertain(self) -> Mapping[str, float]:
        """Uncertain parameters, each with the size [SI] that its relative error refers to."""
        return self.hand.uncertain

    def with_effects(self, *effects: Effect) -> "LinearHand":
        """Return a plant whose hand has `effects` too."""
        return LinearHand(self.hand.with_effects(*effects))

    def with_values(self, values: Mapping[str, float]) -> "LinearHand":
        """Return a plant with other nominal values."""
        return LinearHand(self.hand.with_values(values))

    def accepts(self, effect: Effect) -> str:
        """Return why there is no column of the effect, or an empty string."""
        if isinstance(effect, PartFault):
            return ""
        known = tangent("void").effects
        lacks = [p.name for p in effect.amplitudes if effect.full_name(p.name) not in known]
        return f"no column of {', '.join(lacks)}" if lacks else ""

    def nominal(self, recording: Recording) -> dict[str, float]:
        """Nominal value of every parameter for a run [SI]."""
        return self.hand.nominal(recording)

    def own(self, recording: Recording) -> tuple[str, tuple[str, ...]]:
        """The object of a run, and the parameters of that object alone."""
        return self.hand.own(recording)

    def parts(self, recording: Recording) -> dict[str, bool]:
        """What single parts are off for themselves in a run."""
        return self.hand.parts(recording)

    def same_run(self, recording: Recording) -> bytes:
        """Equal where reference, times and experiment are equal."""
        return self.hand.same_run(recording)

    def judged_part(self, recording: Recording) -> np.ndarray:
        """Every sample is compared."""
        return self.hand.judged_part(recording)

    def phases(self, recording: Recording) -> dict[str, np.ndarray]:
        """Start, closing, holding, opening."""
        return self.hand.phases(recording)

    def simulate(self, parameters: Mapping[str, float], recording: Recording) -> Channels:
        """A run at these parameters; channels that no column has are not there."""
        of = condition(recording)
        columns = {name: np.array([value]) for name, value in parameters.items()}
        (made,) = self.many(columns, recording, tangent(of).channels, False)
        return made

    def many(
        self, columns: Columns, recording: Recording, channels: Sequence[str], exact: bool
    ) -> list[Channels]:
        """A run for each row of the columns."""
        one = tangent(condition(recording))
        found = np.tile(one.base, (len(next(iter(columns.values()))), 1))
        moved = [name for name in columns if name in one.values]
        if moved:
            off = np.array([columns[name] - nominal()[name] for name in moved]).T
            found += off @ np.array([one.values[name] for name in moved])
        for name in columns.keys() & one.effects.keys():
            found += columns[name][:, np.newaxis] * _rows(one, name, columns)
        return [_split(one, row, channels) for row in found]

    def alike(
        self, columns: Columns, recording: Recording, channels: Sequence[str]
    ) -> list[Channels]:
        """As `many`."""
        return self.many(columns, recording, channels, False)

    def apart(
        self,
        parameters: Mapping[str, float],
        share: float,
        recording: Recording,
        channels: Sequence[str],
    ) -> dict[str, tuple[Channels, Channels]]:
        """Changes of channels by each joint off by a share for itself, up and down."""
        one, found = tangent(condition(recording)), {}
        for name, like in self.parts(recording).items():
            if like:
                joint, _, quantity = name.partition(".")
                finger, _, kind = joint.partition("_")
                row = share * one.values[f"{finger}.{kind}_{quantity}"]
                found[name] = (_split(one, row, channels), _split(one, -row, channels))
        return found


def condition(recording: Recording) -> str:
    """Of which condition a recording is."""
    return "dynamometer" if "[object]" in recording.experiment else "void"


def _rows(one: Tangent, name: str, columns: Columns) -> np.ndarray:
    """Change per unit of an amplitude at each row's shape."""
    own = one.effects[name]
    if not isinstance(own, Shaped):
        return own
    at = np.log(np.clip(columns[own.name], own.nodes[0], own.nodes[-1]))
    place = np.interp(at, np.log(own.nodes), np.arange(own.nodes.size))
    low = np.minimum(place.astype(int), own.nodes.size - 2)
    part = (place - low).reshape(-1, *(1,) * (own.rows.ndim - 1))
    between = (1.0 - part) * own.rows[low] + part * own.rows[low + 1]
    if not own.phased:
        return between
    phase = columns[f"{name.partition('.')[0]}.phase"][:, np.newaxis]
    return np.cos(phase) * between[:, 0] + np.sin(phase) * between[:, 1]


def _split(one: Tangent, row: np.ndarray, channels: Sequence[str]) -> Channels:
    pieces = dict(zip(one.channels, np.split(row, len(one.channels)), strict=True))
    return {name: pieces[name] for name in channels}
