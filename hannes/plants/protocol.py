"""What calibrate and diagnose know of a plant: a small protocol, and where plants are found.

The hand, the motor-driven axis, or a user's own class outside the package: docs/own-plant.md walks
through one, hannes/plants/plain.py saves writing most of it.
"""

import importlib
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Protocol, Self, runtime_checkable

import numpy as np

from hannes.core.effect import Effect
from hannes.core.errors import BadInput, nearest
from hannes.core.parameter import ParameterSet
from hannes.core.recording.channel_limits import Expected
from hannes.core.recording.recording import Recording


@runtime_checkable
class Plant(Protocol):
    """A machine that can be simulated under a recording's reference, with effects or without.

    name:       as it stands in a hand.toml's `base`
    channels:   name -> unit of every channel a recording may have, `time` included
    required:   channels without which no simulation can be driven
    judged:     channels in which simulation and recording are compared, where recorded
    parameters: of the base and of `effects`, at the values given
    effects:    those in the model
    free:       parameter -> how far its given value may be off (one standard deviation, SI);
                these are what a refit moves
    block:      time [s] over which what remains is taken as independent

    Angles, times and all else in SI units. A plant may have these besides, and is used without:

    expected:   channel -> Expected (core/recording/channel_limits.py), for `hannes check`
    restless:   parameter -> how far runs of one machine differ in it (one standard deviation, SI);
                calibrate takes what that explains for no misfit, and so does diagnose, where
                they are those of a `run_scatter` of 1 %
    start_time: how far runs start off their clock [s], one standard deviation; 0 without it
    uncertain:  parameter -> size [SI] of which a share is never known; with it diagnose holds all
                of them uncertain and takes its deep way, see hannes/identification/diagnosis
    many(columns, recording, channels, exact): as `simulate` for rows of parameters, quick
                (`exact`: grain of firmware and all); None for a row that breaks down
    alike(columns, recording, channels): as `many`, of rows near the first one, for what they
                differ by: by the steps of that one, so that it is smooth; slopes come from it
    noisy(recording, rows):        columns for `many` by which the firmware of each row reads its
                                   sensors with other noise, as much as the recording has
    unrounded(rows):               columns for `many` by which the firmware of each row rounds
                                   nothing: what its ticks do to an effect then shows by itself
    firmware:   channels that it reads or puts out: effects on them are mended for its ticks
    nominal(recording):            what every parameter is given for a run
    proposals(recorded):           runs worth recording, by name, beside those of each condition
    loggable:   channel -> its unit: what firmware knows, and could log in any run
    own(recording):                the thing handled in a run, and the parameters of that alone
    robust:     channel -> difference [its unit] beyond which diagnose lets a sample pull no harder
                (soft L1): for recordings with outliers
    catalogue:  name -> effect of this plant alone, tried besides the catalogue of all
    read(path):                    recordings of one file by name: of a logger of its own, or of
                                   one that puts several runs into a file
    check(recording):              raises BadInput for what `simulate` could not start from
    smooth(parameters, recording): as `simulate`, quicker and without the grain of firmware, to
                                   take slopes from
    """

    name: str
    channels: Mapping[str, str]
    required: tuple[str, ...]
    judged: tuple[str, ...]
    parameters: ParameterSet
    effects: tuple[Effect, ...]
    block: float

    @property
    def free(self) -> Mapping[str, float]: ...

    def with_effects(self, *effects: Effect) -> Self:
        """Return a plant whose model has `effects` too, at `off` until given a value."""
        ...

    def with_values(self, values: Mapping[str, float]) -> Self:
        """Return a plant with other given values; BadInput on unknown name or bounds."""
        ...

    def accepts(self, effect: Effect) -> str:
        """Return why the plant cannot carry `effect`, or an empty string where it can."""
        ...

    def simulate(
        self, parameters: Mapping[str, float], recording: Recording
    ) -> dict[str, np.ndarray]:
        """Channels at the recording's times, shape (n,): at least those of `judged`.

        `parameters` stand over the given values. The same arguments give the same numbers. Raises
        ComputationFailed where the machine cannot be simulated so.
        """
        ...

    def same_run(self, recording: Recording) -> bytes:
        """Equal for recordings of which one simulation does for all."""
        ...

    def judged_part(self, recording: Recording) -> np.ndarray:
        """Mask of the samples that count."""
        ...

    def phases(self, recording: Recording) -> dict[str, np.ndarray]:
        """Masks of the parts of a run that a person would tell apart."""
        ...


PLANTS = {
    "hand": "hannes.plants.hand.plant:HandPlant",
    "axis": "hannes.plants.axis.plant:Axis",
    "finger": "hannes.plants.finger.plant:Finger",
}


def find_plant(name: str, folder: Path | None = None) -> Plant:
    """Return a plant by name, or the user's own by `package.module:object`.

    The user's module is also looked for in `folder`. Raises BadInput where there is none.
    """
    place = PLANTS.get(name, name)
    module, _, attribute = place.partition(":")
    if not attribute:
        hint = nearest(name, PLANTS) or f"; expected {', '.join(PLANTS)} or package.module:object"
        raise BadInput(f'unknown plant "{name}"{hint}')
    found = _imported(module, attribute, folder)
    plant = found() if isinstance(found, type) else found
    if not isinstance(plant, Plant):
        raise BadInput(f"{place} is no plant: it lacks {', '.join(_lacks(plant))}")
    if fault := _fault(plant):
        raise BadInput(f"plant {place}: {fault}")
    return plant


def _fault(plant: Plant) -> str:
    """What contradicts itself in a plant's attributes, or an empty string."""
    if plant.channels.get("time") != "s":
        return 'channels lacks "time": "s"'
    for what in ("required", "judged"):
        for name in getattr(plant, what):
            if name not in plant.channels:
                return f'{what} names "{name}", which is no channel{nearest(name, plant.channels)}'
    if not plant.judged:
        return "judged is empty: nothing would be compared"
    for name, size in plant.free.items():
        if name not in plant.parameters:
            return f'free names "{name}", which is no parameter{nearest(name, plant.parameters)}'
        if not size >= 0.0:
            return f"free: {name} has the standard deviation {size!r}, expected zero or more"
    return "" if plant.block > 0.0 else f"block = {plant.block!r}: expected seconds above zero"


def _imported(module: str, attribute: str, folder: Path | None) -> Any:
    before = list(sys.path)
    if folder is not None:
        sys.path.insert(0, str(folder))
        _forget_namesake(module, folder)
    try:
        return getattr(importlib.import_module(module), attribute)
    except (Exception, SystemExit) as error:  # the user's module may do anything
        raise BadInput(f"plant {module}:{attribute} cannot be loaded: {error}") from None
    finally:
        sys.path[:] = before


def _forget_namesake(module: str, folder: Path) -> None:
    """Let a module of this folder be loaded although one of the same name is, from elsewhere."""
    own = (folder / f"{module.replace('.', '/')}.py").resolve()
    loaded = sys.modules.get(module)
    if own.is_file() and loaded is not None and Path(loaded.__file__ or "").resolve() != own:
        del sys.modules[module]


def _lacks(plant: object) -> list[str]:
    names = [*Plant.__annotations__, *(n for n in vars(Plant) if not n.startswith("_"))]
    return [name for name in dict.fromkeys(names) if not hasattr(plant, name)]


def expectations(plant: Plant) -> Mapping[str, Expected]:
    """What a plant expects of its channels; a plant may leave out the attribute `expected`."""
    return getattr(plant, "expected", {})


def robust(plant: Plant, channel: str) -> float:
    """Difference beyond which a sample pulls no harder; infinite where the plant says nothing."""
    return float(getattr(plant, "robust", {}).get(channel, np.inf))


def require_usable(plant: Plant, recording: Recording) -> None:
    """Raise the BadInput of a plant's own `check(recording)`; a plant may leave that out.

    It tells before any work what `simulate` could not start from.
    """
    if (check := getattr(plant, "check", None)) is not None:
        check(recording)


def free_amplitudes(effect: Effect) -> dict[str, float]:
    """Full names of an effect's parameters, with the size on which a refit moves them."""
    return {
        effect.full_name(each.name): (each.bounds[1] - each.bounds[0]) / 20.0
        for each in effect.parameters
    }
