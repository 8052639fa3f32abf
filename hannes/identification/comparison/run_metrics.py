"""The paper's metrics of one run, measured and simulated; for each that has none, the reason."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from hannes.identification.comparison.aligned_run import SAMPLING, AlignedRun, Channels
from hannes.identification.grasp_features import GRASP
from hannes.simulation import grasp_metrics
from hannes.simulation.grasp_metrics import DEFINITIONS, relative_error

RIGID = 5500.0  # N/m, stiffness from which an object counts as rigid, as in the data sets
TOUCHING = 1.0  # N, force that shows contact
TOUCH = 0.02  # s after first contact over which a true one holds half of that force on average
CLOSURE = ("closing time", "void current")
NAMES = (*CLOSURE, *GRASP)
BY_FORCE = ("contact", "I_avgc", "I_avgo", "I_sc", "F_max")  # need to know when it touches
BY_CURRENT = ("void current", "I_avgc", "I_avgo", "I_max", "I_sc", "I_so")
BY_POSITION = ("closing time", "I_avgo")
VOID_END = 0.30  # s, up to which the void current is averaged


@dataclass(frozen=True)
class Pair:
    """A metric of one run, measured and simulated, in SI units."""

    measured: float
    simulated: float

    @property
    def error(self) -> float:
        """Equation 4 of the paper, with its sign [%]."""
        return relative_error(self.measured, self.simulated)


@dataclass(frozen=True, eq=False)
class RunMetrics:
    """Metrics of one run by name; `left_out` says why for each that does not stand there."""

    run: AlignedRun
    pairs: dict[str, Pair]
    left_out: dict[str, str]


def run_metrics(run: AlignedRun) -> RunMetrics:
    """Measure a run: a free closure where its experiment has no object, else a grasp."""
    left_out = dict(_without_sense(run))
    asked = [name for name in (GRASP if run.stiffness else CLOSURE) if name not in left_out]
    sides = [_values(run, channels) for channels in (run.measured, run.simulated)] if asked else []
    pairs = {}
    for name in asked:
        measured, simulated = (float(side.get(name, np.nan)) for side in sides)
        if measured and np.isfinite([measured, simulated]).all():
            pairs[name] = Pair(measured, simulated)
        else:
            side = "simulation" if np.isfinite(measured) and measured else "recording"
            left_out[name] = f"the {side} has no value by its definition ({DEFINITIONS[name]})"
    return RunMetrics(run, pairs, left_out)


def _without_sense(run: AlignedRun) -> Iterator[tuple[str, str]]:
    """Metrics that have no meaning for a run, with the reason; the last one said counts."""
    asked = GRASP if run.stiffness else CLOSURE
    needs = {"current": BY_CURRENT, "position": BY_POSITION}
    for channel, names in needs.items():
        if channel not in run.measured:
            yield from ((n, f"no {channel} was recorded") for n in names if n in asked)
    yield from _by_touch(run) if run.stiffness else _closure(run)
    if run.stiffness and run.stiffness < RIGID:
        soft = f"the object is soft ({run.stiffness:g} N/m; rigid from {RIGID:g} N/m)"
        yield "I_so", soft
    if run.reference.max() <= run.reference[0]:
        yield from ((name, "the command does not close the hand") for name in asked)


def _closure(run: AlignedRun) -> Iterator[tuple[str, str]]:
    if run.touch and run.measured[run.touch].max() > TOUCHING:
        why = (
            f"the hand touches something ({run.touch} above 1 N), but its experiment has no object"
        )
        yield from ((name, why) for name in CLOSURE)
    elif run.time[-1] < VOID_END:
        yield "void current", "the recording ends before 0.30 s of the command"


def _by_touch(run: AlignedRun) -> Iterator[tuple[str, str]]:
    if not run.touch:
        why = "no force was recorded, by which contact is found (force_N, or sensor_N)"
        yield from ((name, why) for name in BY_FORCE)
        return
    for what, channels in (("simulation", run.simulated), ("recording", run.measured)):
        if why := _no_contact(channels[run.touch]):
            yield from ((name, f"{why} in the {what}") for name in GRASP)


def _no_contact(force: np.ndarray) -> str:
    """Why a force [N] does not show contact, or an empty string."""
    touching = force > TOUCHING
    if not touching.any():
        return "no contact: the force stays below 1 N"
    first = int(np.argmax(touching))
    after = force[first : first + round(TOUCH * SAMPLING)]
    if first == 0 or after.mean() < TOUCHING / 2.0:
        return "contact cannot be determined: noise or offset of the force reaches 1 N"
    return ""


def _values(run: AlignedRun, channels: Channels) -> dict[str, float]:
    """All metrics of one side; NaN where one has no sense."""
    nothing = np.full(run.time.size, np.nan)
    current, position = (channels.get(name, nothing) for name in ("current", "position"))
    if not run.stiffness:
        return {
            "closing time": grasp_metrics.closing_time(run.time, position),
            "void current": grasp_metrics.void_current(run.time, current),
        }
    size = grasp_metrics.smoothed(current, SAMPLING)
    alone = {
        "I_max": float(size.max()),
        "I_so": grasp_metrics.falling_slope(run.time, size),
    }
    if not run.touch:
        return alone
    found = grasp_metrics.grasp_metrics(run.time, current, channels[run.touch], position)
    return {name: getattr(found, name) for name in GRASP}
