"""What calibrate and diagnose know of a plant: a small protocol, and where plants are found.

A plant is the hand, the motor-driven axis, the finger, or a user's own class outside the package.
docs/how-to/write-a-plant.md lists what it may have; `PlainPlant` saves writing most of it.
"""

import importlib
import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import Protocol, Self, cast, runtime_checkable

import numpy as np

from hannes.core.effect import Effect
from hannes.core.errors import BadInput, NotTrusted, nearest
from hannes.core.parameter import ParameterSet
from hannes.core.recording.channel_limits import Expected
from hannes.core.recording.recording import Recording
from hannes.core.trust.consent import own_object
from hannes.core.trust.python_source import is_own


@runtime_checkable
class Plant(Protocol):
    """A machine that can be simulated under a recording's reference, with effects or without.

    name:       as it stands in a hand.toml's `base`
    channels:   name -> unit of every channel a recording may have, `time` included
    required:   channels without which no simulation can be driven
    judged:     channels in which simulation and recording are compared, where recorded
    parameters: of the base and of `effects`, at their nominal values
    effects:    those in the model
    free:       parameter -> standard deviation of its nominal value [SI]; these a refit fits
    block:      time [s] over which residuals are taken as independent

    All values are in SI units. A plant may have these besides, and works without:

    expected:   channel -> Expected (core/recording/channel_limits.py), for `hannes check`
    run_to_run: parameter -> run-to-run standard deviation on one machine [SI]. Calibrate takes
                what it explains as noise. So does diagnose, for a `run_scatter` of 1 %. Its former
                name `restless` is read for one release, with a DeprecationWarning
    start_time: standard deviation of a run's start against its clock [s]; 0 without it
    uncertain:  parameter -> size [SI] that its relative error refers to. With it diagnose takes
                all of them as uncertain, see hannes/identification/diagnosis
    parts(recording): what single parts may be off for themselves in a run, beside what the
                parameters say: name -> True for one of several like parts (a joint), False for
                one of its own (the object of an experiment). Calibrate takes these as uncertain
    apart(parameters, share, recording, channels): name of each of several like parts -> two
                changes of channels, each name -> shape (n,): with it off by `share` (relative), and
                by as much the other way. Diagnose takes these as uncertain
    together(parameters, share, recording, channels): of some machines whose like parts are all off
                at once, by normal draws of that size, two such changes each, {} where a run
                fails: parts together do not always what they do one by one. Draws are the same
                for every recording
    with_parts(deviations): the plant, effects and all, with like parts off for themselves: by the
                names of `apart`, relative to what they are. Diagnose then simulates what it finds
    slopes(parameters, steps, recording, channels): name -> channel -> its change, shape (n,), per
                unit of each parameter of `steps` [SI], and per relative deviation of each part
    many(columns, recording, channels, exact): as `simulate` for rows of parameters, fast
                (`exact`: with the sampled controller); None for a row that fails. The list may
                have `work`: what the runs took, as seconds of ordinary ones, for the bound of work
    longest_counted: what a run counts [s] for that bound, at most, however slow its command is
    alike(columns, recording, channels): as `many` for rows near the first one, with its solver
                steps; differences between them are smooth, and derivatives come from them
    noisy(recording, rows):        columns for `many` by which the controller of each row reads its
                                   sensors with other noise, of the recording's size
    noise_bandwidth(repeats):      bandwidth [Hz] of that noise by repeats of each command, 0 for
                                   white noise; `noisy` then takes it as `bandwidth`. None where
                                   none show it: `noisy` is then asked without
    unrounded(rows):               columns for `many` by which the controller of each row rounds
                                   nothing; this isolates the effect of sampling
    firmware:   channels that the controller reads or writes: effects on them are corrected for
                its sampling
    sampled(recording):            the recording under a sampled controller, None where its
                experiment has one. With `tick`, the parameter that is its period, diagnose sees
                whether recordings were made so though their experiments say otherwise
    counted(recording):            whether its position stands in whole counts of an encoder
    nominal(recording):            nominal value of every parameter for a run
    proposals(recorded):           candidate experiments, by name, beside those of each condition
    loggable:   channel -> its unit: what the controller knows, and could log in any run
    own(recording):                the object of a run, and the parameters of that object alone
    robust:     channel -> residual [its unit] beyond which a sample counts less (soft L1), for
                recordings with outliers
    compiled_from: its written equations, into which effects are compiled; without it they run as
                plain Python
    catalogue:  name -> effect of this plant alone, tried besides the common catalogue
    generic:    name -> Description of this plant alone, for what cannot be named
    quantities(recording):         what a residual may go with, name -> shape (n,): `angle`,
                                   `speed`, `load`; `contact` is 1 while something is touched
    read(path):                    recordings of one file by name: of a logger of its own, or of
                                   one that writes several runs into a file
    check(recording):              raises BadInput for what `simulate` could not start from
    smooth(parameters, recording): as `simulate`, faster and with the continuous controller, for
                                   derivatives
    """

    name: str
    channels: Mapping[str, str]
    required: tuple[str, ...]
    judged: tuple[str, ...]
    parameters: ParameterSet
    effects: tuple[Effect, ...]
    block: float

    @property
    def free(self) -> Mapping[str, float]:
        """Standard deviation of each given value that a fit may move, by full name, SI."""
        ...

    def with_effects(self, *effects: Effect) -> Self:
        """Return a plant whose model has `effects` too, at `off` until a value is set."""
        ...

    def with_values(self, values: Mapping[str, float]) -> Self:
        """Return a plant with other nominal values [SI]; BadInput on unknown name or bounds."""
        ...

    def accepts(self, effect: Effect) -> str:
        """Return why the plant cannot carry `effect`, or an empty string where it can."""
        ...

    def simulate(
        self, parameters: Mapping[str, float], recording: Recording
    ) -> dict[str, np.ndarray]:
        """Channels at the recording's times, shape (n,): at least those of `judged`.

        `parameters` [SI] override the nominal values. The same arguments give the same numbers.
        Raises ComputationFailed where the machine cannot be simulated so.
        """
        ...

    def same_run(self, recording: Recording) -> bytes:
        """Return a key, equal for recordings that one simulation serves."""
        ...

    def judged_part(self, recording: Recording) -> np.ndarray:
        """Return the mask of the samples that are compared, shape (n,)."""
        ...

    def phases(self, recording: Recording) -> dict[str, np.ndarray]:
        """Return masks of the phases of a run, by name, each of shape (n,)."""
        ...


@runtime_checkable
class PlantOfParts(Protocol):
    """What a plant has besides whose like parts can be off for themselves."""

    def with_parts(self, deviations: Mapping[str, float]) -> Plant:
        """Return the plant with parts so far off, relative, by the names of `apart`."""
        ...


PLANTS = {
    "hand": "hannes.plants.hand.plant:HandPlant",
    "axis": "hannes.plants.axis.plant:Axis",
    "finger": "hannes.plants.finger.plant:Finger",
}


def find_plant(name: str, folder: Path | None = None, toml: str | Path | None = None) -> Plant:
    """Return a shipped plant by name, or the user's own by `file.py:NAME` or `module:NAME`.

    The user's is looked for in `folder` (default: the current one), a module also among those
    installed; `toml` is the file that names it, which needs consent (docs/explanation/trust.md).
    Raises BadInput where there is none, or where it raises by itself.
    """
    if name in PLANTS or not is_own(name):
        return shipped_plant(name)
    try:
        found = own_object(name, folder or Path.cwd(), toml)
    except NotTrusted:
        raise
    except BadInput as error:
        raise BadInput(f"plant {name} cannot be loaded: {error}") from None
    try:
        plant: Plant = found() if isinstance(found, type) else found
        lacking = _lacks(plant)
        fault = "" if lacking else _fault(plant)
    except BadInput as error:
        raise BadInput(f"plant {name}: {error}") from None
    except (Exception, SystemExit) as error:  # of the user's own code
        what = f"{type(error).__name__}: {error}"
        raise BadInput(f"plant {name} raises when it is made or looked at: {what}") from None
    if lacking:
        raise BadInput(f"{name} is no plant: it lacks {', '.join(lacking)}")
    if fault:
        raise BadInput(f"plant {name}: {fault}")
    return plant


def shipped_plant(name: str) -> Plant:
    """Return a plant that ships with hannes: all that data may choose from; BadInput otherwise."""
    if name not in PLANTS:
        expected = f"; expected {', '.join(PLANTS)}, file.py:NAME or module:NAME"
        raise BadInput(f'unknown plant "{name:.80}"{nearest(name, PLANTS) or expected}')
    module, _, attribute = PLANTS[name].partition(":")
    plant: Plant = getattr(importlib.import_module(module), attribute)()
    return plant


def _fault(plant: Plant) -> str:
    """What contradicts itself in a plant's attributes, or an empty string."""
    if not (isinstance(plant.name, str) and plant.name):
        return f"name = {plant.name!r}: expected a text"
    channels: object = plant.channels
    if not isinstance(channels, Mapping):
        return f"channels is {channels!r:.80}: expected units by name"
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


def _lacks(plant: object) -> list[str]:
    names = [*Plant.__annotations__, *(n for n in vars(Plant) if not n.startswith("_"))]
    return [name for name in dict.fromkeys(names) if not hasattr(plant, name)]


def expectations(plant: Plant) -> Mapping[str, Expected]:
    """What a plant expects of its channels; a plant may leave out the attribute `expected`."""
    return getattr(plant, "expected", {})


def commanded(plant: Plant) -> frozenset[str]:
    """Channels that were asked for, not measured.

    What another follows, and what a plant requires, does not judge, and does not say to follow.
    """
    expected = expectations(plant)
    following = {name for name, each in expected.items() if each.follows}
    followed = {each.follows for each in expected.values() if each.follows}
    asked = frozenset(plant.required) - {*plant.judged, *following, "time"}
    return asked | followed | {"reference", "pulses"} & plant.channels.keys()


def run_to_run_spread(plant: Plant) -> Mapping[str, float]:
    """Return the run-to-run standard deviation of each parameter [SI]; empty where undeclared.

    Reads the attribute `run_to_run`, else its former name `restless` with a DeprecationWarning.
    """
    if hasattr(plant, "run_to_run"):
        return dict(plant.run_to_run)
    if not hasattr(plant, "restless"):
        return {}
    warnings.warn(
        f"plant {plant.name}: the attribute restless is now called run_to_run; rename it",
        DeprecationWarning,
        stacklevel=2,
    )
    return dict(plant.restless)


def with_parts(plant: Plant, deviations: Mapping[str, float]) -> Plant:
    """Return the plant with like parts so far off for themselves, relative, by name.

    The plant itself where none is off. One that is off needs a plant that has `with_parts`.
    """
    return cast(PlantOfParts, plant).with_parts(deviations) if deviations else plant


def robust(plant: Plant, channel: str) -> float:
    """Return the residual beyond which a sample counts less; infinite where none is declared."""
    return float(getattr(plant, "robust", {}).get(channel, np.inf))


def require_usable(plant: Plant, recording: Recording) -> None:
    """Raise the BadInput of a plant's own `check(recording)`; a plant may leave that out.

    It reports before any computation what `simulate` could not start from.
    """
    if (check := getattr(plant, "check", None)) is not None:
        check(recording)


def shown(plant: Plant) -> str:
    """A plant in one line: its class, effects in its model, number of parameters."""
    names = ", ".join(each.name for each in plant.effects)
    count = len(plant.parameters)
    return f"{type(plant).__name__}(effects=[{names}], {count} parameters)"


def free_amplitudes(effect: Effect) -> dict[str, float]:
    """Return full names of an effect's fitted parameters, the scale of each in a refit [SI]."""
    return {
        effect.full_name(each.name): (each.bounds[1] - each.bounds[0]) / 20.0
        for each in effect.fitted
    }
