"""Many simulations of one recording's run at once: the full diagnosis of a hand needs them."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from hannes.core.effect import Effect
from hannes.core.recording.recording import Recording
from hannes.core.recording.white_noise import roughness
from hannes.simulation.batch.simulate_many import simulate_alike, simulate_many
from hannes.simulation.experiment.experiment import Experiment
from hannes.simulation.hand.hand import Hand
from hannes.simulation.trajectory import Grasp, Outcome

TOLERANCE = 1e-5  # derivatives by weak parameters are right; at 1e-4 they are mere solver error
WIDE = 1e-4  # for many runs near each other: sampling errors add up to 2e-4 of the peak
# Channels that the controller reads and writes.
FIRMWARE: tuple[str, ...] = ("reference_time", "sensed_current", "measured_current", "reading_age")
FIRMWARE += ("delayed_position", "delayed_current", "duty")
FINEST = 32.0  # bits of an encoder that rounds to a nanoradian
COUNTED = 0.05  # of a step: a file of six digits rounds by that at 20 rad
SAME = 1e-9  # s: times that differ by rounding alone
NOISE = "controller.current_noise"
USUAL = 3500.0  # evaluations of the hand's equations for a second of an ordinary grasp
Channels = dict[str, np.ndarray]


class MadeRuns(list[Channels | None]):
    """Channels of runs; `work`: what they took, as seconds of an ordinary grasp."""

    def __init__(self, made: Iterable[Channels | None], work: float) -> None:
        super().__init__(made)
        self.work = work


def alike(
    hand: Hand,
    experiment: Experiment,
    recording: Recording,
    columns: Mapping[str, np.ndarray],
    channels: Sequence[str],
) -> list[Channels | None]:
    """As `many` with the continuous controller, for rows near the first one, by its solver steps.

    Use only differences between rows: the solver's error cancels in them.
    """
    return _Runs(hand, experiment, recording, tuple(channels)).alike(columns, WIDE)


def nominal(hand: Hand, experiment: Experiment) -> dict[str, float]:
    """Nominal value of every parameter for a run, in SI units, by full name.

    Values of the experiment override those of the hand.
    """
    return {**hand.parameters, **experiment.overrides()}


def own(experiment: Experiment) -> tuple[str, tuple[str, ...]]:
    """The object of a run, as text, and the parameters of that object alone.

    Two runs have one object where its shape and all its values in the experiment are equal.
    """
    if experiment.object is None:
        return "nothing", ()
    given = sorted((n, v) for n, v in experiment.overrides().items() if n.startswith("object."))
    values = ", ".join(f"{name}={value!r}" for name, value in given)
    return f"{experiment.object.shape} {values or 'of the hand'}", _FEATURES


_FEATURES = ("object.stiffness", "object.damping", "object.friction", "object.x", "object.y")


def many(
    hand: Hand,
    experiment: Experiment,
    recording: Recording,
    columns: Mapping[str, np.ndarray],
    channels: Sequence[str],
    exact: bool,
) -> list[Channels | None]:
    """Channels at the recorded times for each row of `columns` [SI], None where a run fails.

    `exact` runs the experiment's own controller, else the continuous one. All effects of the hand
    are in the model, whatever their sizes. Rows with noisy sensors (`noisy`) must be near each
    other.
    """
    asked = experiment if exact else replace(experiment, controller="continuous")
    runs = _Runs(hand, asked, recording, tuple(channels))
    if exact and NOISE in columns:
        return runs.near(columns)
    return runs.of(columns, TOLERANCE)


@dataclass(frozen=True)
class _Runs:
    """Runs of a hand in an experiment, at the times of a recording of it."""

    hand: Hand
    experiment: Experiment
    recording: Recording
    channels: tuple[str, ...]

    def of(self, columns: Mapping[str, np.ndarray], rtol: float) -> list[Channels | None]:
        """Channels at the recorded times for each row."""
        effects: tuple[Effect, ...] = self.hand.effects
        runs = simulate_many(
            self.hand,
            self.experiment,
            columns,
            channels=self.channels,
            rtol=rtol,
            effects=effects,
            progress=False,  # the caller reports progress
        )
        return self._recorded(runs)

    def alike(self, columns: Mapping[str, np.ndarray], rtol: float) -> list[Channels | None]:
        """The same, all rows by the steps of the first one."""
        runs = simulate_alike(
            self.hand,
            self.experiment,
            columns,
            channels=self.channels,
            rtol=rtol,
            effects=self.hand.effects,
        )
        return self._recorded(runs)

    def _recorded(self, runs: Iterable[Grasp]) -> MadeRuns:
        """At the recorded times."""
        since = self.recording.time - self.recording.time[0]
        if "reference" not in self.recording:
            since = self.recording.time
        evaluations, made = 0, list[Channels | None]()
        for run in runs:
            evaluations += run.cost.evaluations
            done = run.outcome is Outcome.COMPLETED
            made.append(_sampled_at(since, run, self.channels) if done else None)
        return MadeRuns(made, evaluations / USUAL)

    def near(self, columns: Mapping[str, np.ndarray]) -> list[Channels | None]:
        """The same for rows that differ little, fast.

        The sampling error at a wide tolerance is the same for all of them. One run in their middle,
        with a controller that rounds nothing, gives it.
        """
        middle = {name: np.atleast_1d(np.mean(column)) for name, column in columns.items()}
        middle |= {NOISE: np.zeros(1), "controller.noise_seed": np.ones(1), **unrounded(1)}
        fine, wide = (self.of(middle, rtol)[0] for rtol in (TOLERANCE, WIDE))
        more: Channels = {}
        if fine is not None and wide is not None:
            more = {name: fine[name] - wide[name] for name in self.channels}
        found = self.of(columns, WIDE)
        return [run and self._logged({n: run[n] + more.get(n, 0.0) for n in run}) for run in found]

    def _logged(self, run: Channels) -> Channels:
        """The run with its position in counts of the encoder, where the recording's is."""
        step = 2.0 * np.pi / 2.0 ** self.hand.parameters["encoder.bits"]
        if "position" in run and _in_steps(self.recording["position"], step):
            run["position"] = step * np.round(run["position"] / step)
        return run


def _sampled_at(times: np.ndarray, run: Grasp, channels: Sequence[str]) -> Channels:
    """Channels of a run at some times [s], as they are where it was sampled then."""
    own = run.time
    if own.size == times.size and np.abs(own - times).max() < SAME:
        return {name: run[name] for name in channels}
    return {name: np.interp(times, own, run[name]) for name in channels}


def counted(hand: Hand, recording: Recording) -> bool:
    """Whether a recorded position stands in whole counts of the hand's encoder, and moves."""
    step = 2.0 * np.pi / 2.0 ** hand.parameters["encoder.bits"]
    if "position" not in recording or np.ptp(recording["position"]) < step:
        return False
    return _in_steps(recording["position"], step)


def _in_steps(values: np.ndarray, step: float) -> bool:
    counts = values / step
    return bool(np.all(np.abs(counts - np.round(counts)) < COUNTED))


def noisy(
    hand: Hand,
    experiment: Experiment,
    recording: Recording,
    count: int,
    bandwidth: float | None = None,
) -> dict[str, np.ndarray]:
    """Columns by which the controller of each of `count` runs reads its current with other noise.

    The level makes the current as noisy as the recorded one. Noise in the loop moves the motor,
    which adds to the noise of the sensor; rounding does too. bandwidth: Hz, 0 for white noise; by
    default the hand's own
    """
    if "current" not in recording:
        return {}
    if bandwidth is None:
        bandwidth = hand.parameters["controller.noise_bandwidth"]
    rough = roughness(recording["current"])
    level = rough / smoothness(bandwidth, recording)
    columns = noise_columns(np.array([0.0, level]), bandwidth)
    runs = _Runs(hand, experiment, recording, ("current",)).of(columns, WIDE)
    quiet, loud = (0.0 if run is None else roughness(run["current"]) for run in runs)
    noise = max(rough**2 - quiet**2, 0.0) / max(loud**2 - quiet**2, 1e-30)
    return noise_columns(np.full(count, level * min(1.0, float(np.sqrt(noise)))), bandwidth)


def noise_columns(
    levels: np.ndarray, bandwidth: ArrayLike = 0.0, first: int = 1
) -> dict[str, np.ndarray]:
    """Columns of noise of these levels [A], numbered from `first`.

    bandwidth: Hz, one for all or one for each
    """
    return {
        NOISE: levels,
        "controller.noise_seed": np.arange(levels.size, dtype=float) + first,
        "controller.noise_bandwidth": np.broadcast_to(np.asarray(bandwidth, float), levels.size),
    }


def smoothness(bandwidth: float, recording: Recording) -> float:
    """Roughness of noise over its standard deviation, in a recording's samples.

    bandwidth: Hz, 0 for white noise, where that is 1
    """
    if not bandwidth:
        return 1.0
    interval = float(np.median(np.diff(recording.time)))
    keep = np.exp(-2.0 * np.pi * bandwidth * interval)
    return float(np.sqrt((6.0 - 8.0 * keep + 2.0 * keep**2) / 6.0))


def unrounded(count: int) -> dict[str, np.ndarray]:
    """Columns by which the controller of each of `count` runs rounds neither angle nor current."""
    return {
        "encoder.bits": np.full(count, FINEST),
        "controller.current_step": np.zeros(count),
    }
