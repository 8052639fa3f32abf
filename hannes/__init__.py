"""A model of the Hannes prosthetic hand that says what it is missing when a recording disagrees."""

import importlib
from typing import TYPE_CHECKING, Any

from hannes.core import version as _version

__version__ = _version.VERSION

if TYPE_CHECKING:
    from hannes.campaigns.check import check as check
    from hannes.campaigns.convert import convert as convert
    from hannes.commands.calibrate import calibrate as calibrate
    from hannes.commands.diagnose import diagnose as diagnose
    from hannes.core.recording.recording import Recording as Recording
    from hannes.simulation.batch.simulate_many import simulate_many as simulate_many
    from hannes.simulation.catalogue import effects as effects
    from hannes.simulation.experiment.experiment import Experiment as Experiment
    from hannes.simulation.experiment.experiment import Reference as Reference
    from hannes.simulation.experiment.experiment import Target as Target
    from hannes.simulation.experiment.load import load_experiment as load_experiment
    from hannes.simulation.hand.hand import Hand as Hand
    from hannes.simulation.sensors import observe as observe
    from hannes.simulation.simulate import simulate as simulate

# Loaded when first asked for, so that `import hannes` costs nothing.
_HOMES = {
    "Experiment": "simulation.experiment.experiment",
    "Hand": "simulation.hand.hand",
    "Recording": "core.recording.recording",
    "Reference": "simulation.experiment.experiment",
    "Target": "simulation.experiment.experiment",
    "calibrate": "commands.calibrate",
    "check": "campaigns.check",
    "convert": "campaigns.convert",
    "diagnose": "commands.diagnose",
    "effects": "simulation.catalogue",
    "load_experiment": "simulation.experiment.load",
    "observe": "simulation.sensors",
    "simulate": "simulation.simulate",
    "simulate_many": "simulation.batch.simulate_many",
}
__all__ = sorted(_HOMES)


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(f"{__name__}.{_HOMES[name]}"), name)


def __dir__() -> list[str]:
    return __all__
