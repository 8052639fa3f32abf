"""Methods that draw, bound to classes of packages below when the public names are loaded.

So a recording draws itself by `recording.plot()`, and its package still knows no figures.
"""

import importlib
import sys
from collections.abc import Callable
from typing import Any

# Class by its module -> method -> function of report/plots.py.
METHODS = {
    ("hannes.core.recording.recording", "Recording"): {
        "plot": "recording_plot", "_repr_html_": "recording_html",
    },
    ("hannes.simulation.trajectory", "Trajectory"): {
        "plot": "trajectory_plot", "_repr_html_": "trajectory_html",
    },
    ("hannes.commands.diagnose", "Diagnosis"): {
        "plot": "diagnosis_plot", "_repr_html_": "diagnosis_html",
    },
    ("hannes.simulation.experiment.experiment", "Experiment"): {
        "_repr_html_": "experiment_html",
    },
    ("hannes.simulation.hand.hand", "Hand"): {"_repr_html_": "hand_html"},
}  # fmt: skip


def bind() -> None:
    """Give every class that is loaded its methods, once."""
    for (module, name), methods in METHODS.items():
        kind = getattr(sys.modules.get(module), name, None)
        if kind is not None and "_repr_html_" not in vars(kind):
            for method, function in methods.items():
                setattr(kind, method, _late(method, function))


def _late(method: str, function: str) -> Callable[..., Any]:
    """A method that loads what draws when it is called."""

    def call(self: Any, *args: Any, **options: Any) -> Any:
        plots = importlib.import_module("hannes.report.plots")
        return getattr(plots, function)(self, *args, **options)

    call.__name__ = method
    call.__doc__ = f"See hannes.report.plots.{function}."
    return call
