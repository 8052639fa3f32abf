"""A model of the Hannes prosthetic hand that says what it is missing when a recording disagrees."""

import importlib
from typing import TYPE_CHECKING, Any

from hannes.core import former_names as _former_names
from hannes.core import version as _version
from hannes.report import bound as _bound

__version__ = _version.VERSION

if TYPE_CHECKING:
    from hannes.campaigns.check import check as check
    from hannes.campaigns.convert import convert as convert
    from hannes.commands.calibrate import calibrate as calibrate
    from hannes.commands.compare import compare as compare
    from hannes.commands.diagnose import diagnose as diagnose
    from hannes.commands.view import view as view
    from hannes.core.effect import Effect as Effect
    from hannes.core.effect import Term as Term
    from hannes.core.errors import BadInput as BadInput
    from hannes.core.errors import ComputationFailed as ComputationFailed
    from hannes.core.kernels.insertion import open_to_effects as open_to_effects
    from hannes.core.kernels.jit import kernel as kernel
    from hannes.core.layout import Slot as Slot
    from hannes.core.parameter import Parameter as Parameter
    from hannes.core.recording.channel_limits import Expected as Expected
    from hannes.core.recording.recording import Recording as Recording
    from hannes.plants.compiled import CompiledPlant as CompiledPlant
    from hannes.plants.plain import PlainPlant as PlainPlant
    from hannes.plants.protocol import Plant as Plant
    from hannes.simulation.batch.simulate_many import simulate_many as simulate_many
    from hannes.simulation.catalogue import effects as effects
    from hannes.simulation.compiler.assemble import Equations as Equations
    from hannes.simulation.experiment.experiment import Experiment as Experiment
    from hannes.simulation.experiment.experiment import Reference as Reference
    from hannes.simulation.experiment.experiment import Target as Target
    from hannes.simulation.experiment.load import load_experiment as load_experiment
    from hannes.simulation.hand.hand import Hand as Hand
    from hannes.simulation.sensors import observe as observe
    from hannes.simulation.simulate import simulate as simulate
    from hannes.simulation.stepper import Stepper as Stepper
    from hannes.simulation.stepper import start as start

# Loaded when first asked for, so that `import hannes` costs nothing.
_HOMES = {
    "BadInput": "core.errors",
    "CompiledPlant": "plants.compiled",
    "ComputationFailed": "core.errors",
    "Effect": "core.effect",
    "Equations": "simulation.compiler.assemble",
    "Expected": "core.recording.channel_limits",
    "Experiment": "simulation.experiment.experiment",
    "Hand": "simulation.hand.hand",
    "Parameter": "core.parameter",
    "PlainPlant": "plants.plain",
    "Plant": "plants.protocol",
    "Recording": "core.recording.recording",
    "Reference": "simulation.experiment.experiment",
    "Slot": "core.layout",
    "Stepper": "simulation.stepper",
    "Target": "simulation.experiment.experiment",
    "Term": "core.effect",
    "calibrate": "commands.calibrate",
    "check": "campaigns.check",
    "compare": "commands.compare",
    "convert": "campaigns.convert",
    "diagnose": "commands.diagnose",
    "effects": "simulation.catalogue",
    "kernel": "core.kernels.jit",
    "load_experiment": "simulation.experiment.load",
    "observe": "simulation.sensors",
    "open_to_effects": "core.kernels.insertion",
    "simulate": "simulation.simulate",
    "simulate_many": "simulation.batch.simulate_many",
    "start": "simulation.stepper",
    "view": "commands.view",
}
__all__ = sorted(_HOMES)

_former_names.install()


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    found = getattr(importlib.import_module(f"{__name__}.{_HOMES[name]}"), name)
    _bound.bind()
    return found


def __dir__() -> list[str]:
    return __all__
