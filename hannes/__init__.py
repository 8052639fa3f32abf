"""A model of the Hannes prosthetic hand that says what it is missing when a recording disagrees."""

import importlib
import sys
from types import ModuleType
from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"
__all__ = [
    "Experiment",
    "Hand",
    "Recording",
    "Reference",
    "Target",
    "calibrate",
    "check",
    "convert",
    "diagnose",
    "effects",
    "load_experiment",
    "observe",
    "simulate",
    "simulate_many",
]

if TYPE_CHECKING:
    from hannes.batch import simulate_many as simulate_many
    from hannes.calibrate import calibrate as calibrate
    from hannes.catalogue import effects as effects
    from hannes.check import check as check
    from hannes.convert import convert as convert
    from hannes.diagnose import diagnose as diagnose
    from hannes.experiment import Experiment as Experiment
    from hannes.experiment import Reference as Reference
    from hannes.experiment import Target as Target
    from hannes.hand import Hand as Hand
    from hannes.observe import observe as observe
    from hannes.recording import Recording as Recording
    from hannes.simulate import simulate as simulate
    from hannes.spec import load_experiment as load_experiment

# Loaded when first asked for, so that `import hannes` costs nothing.
_HOMES = {
    "Experiment": "experiment",
    "Hand": "hand",
    "Recording": "recording",
    "Reference": "experiment",
    "Target": "experiment",
    "calibrate": "calibrate",
    "check": "check",
    "convert": "convert",
    "diagnose": "diagnose",
    "effects": "catalogue",
    "load_experiment": "spec",
    "observe": "observe",
    "simulate": "simulate",
    "simulate_many": "batch",
}


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(f"{__name__}.{_HOMES[name]}"), name)


class _Package(ModuleType):
    """Keeps `hannes.simulate` the function: loading the module of that name would hide it."""

    def __setattr__(self, name: str, value: object) -> None:
        if name not in _HOMES or not isinstance(value, ModuleType):
            super().__setattr__(name, value)

    def __dir__(self) -> list[str]:
        return sorted({*super().__dir__(), *__all__})


sys.modules[__name__].__class__ = _Package
