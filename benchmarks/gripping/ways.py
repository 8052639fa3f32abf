"""Ways to know the stiffness of an object near the border of soft and rigid.

Development objects, put at 2.5 to 12 kN/m; errors are of those from 4 to 7.6 kN/m, as standard
deviations of the stiffness's logarithm. The model's trees and the observer of the force are asked
at the end of a hold under the policy. A quadratic polynomial is fitted to what the current and the
position did from 0.15 s before the touch to 0.74 s after it, cross-validated: pressed as the policy
does in doubt, with a release and a second press in between, and with a touch seen from 0.04 A on.
The networks are those of the model, asked in the loop of those that it pressed on; below, of a
quarter and of a sixteenth of the grasps that trained them, the error on unseen ones of these.
The bound is that of Cramer and Rao: the least error of any estimate without bias that knows the
model, how hands and objects vary, and the noise, linearised about each of a few objects. It is that
of every sample of 1.4 s, and that of means of 20 ms until 0.48 s after the touch. It leaves out
that traces are no straight lines of so many unknown values.

off: of an object, expected of forty whose stiffness has that error, as each of the border's
neighbours is on its wrong side by chance: 40 / ln(40 / 0.5) times 0.8 of the error.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from benchmarks.grip import trained
from benchmarks.gripping.held import FULL, HOLD, SPEED, Disturbed, drawn, empty_hand, model, spec
from benchmarks.harness import Row, main
from hannes import simulate_many
from hannes.bench.force_observer import ForceObserver
from hannes.bench.grip_loop import GripLoop
from hannes.bench.policy import GripSettings
from hannes.bench.simulated_board import SimulatedBoard, grasped
from hannes.dataset.read import read
from hannes.dataset.sampling import SampledGrasp
from hannes.dataset.touch_limit import approaching, limited
from hannes.recognition.pressed import KNOWN
from hannes.recognition.train_pressed import fitted, inputs_of
from hannes.simulation.experiment.experiment import Reference

SET = "development"
LOW, HIGH, NEAR = 2.5e3, 12e3, (4e3, 7.6e3)  # N/m
FIRST, PRESSED, LOOPED, BOUNDED = 1000, 400, 40, 3  # objects: number of the first; of each way
QUICK = 5  # times fewer
PARTS = (16, 4)  # of the grasps that train the networks
NOISE, POSITION, STEP = 0.0112, 5e-4, 0.3  # A, rad; standard deviations, of differences
KEPT = ("noise", "command", "resolution", "floating_object.free", "gravity")
PER_LOG = 40 / np.log(40.0 / 0.5)  # objects of the forty for each factor e of stiffness


def put(number: int, stiffness: float) -> SampledGrasp:
    """Development object `number` at another stiffness [N/m]."""
    return changed(drawn(number, SET), "object.stiffness", stiffness)


def changed(sampled: SampledGrasp, name: str, value: float) -> SampledGrasp:
    """A grasp with another value [SI] of its object or hand."""
    known, target = sampled.experiment, sampled.experiment.object
    if target is None or not name.startswith("object."):
        return replace(sampled, hand=sampled.hand.with_values({name: value}))
    target = replace(target, values={**target.values, name: value})
    return replace(sampled, experiment=replace(known, object=target))


def somewhere(number: int) -> float:
    """A stiffness [N/m] for an object, log-uniform."""
    low, high = np.log((LOW, HIGH))
    return float(np.exp(np.random.default_rng([98, number]).uniform(low, high)))


def ran(sampled: Sequence[SampledGrasp]) -> list[Any]:
    """Grasps without noise, 1.4 s each."""
    pairs = [(s.hand, replace(s.experiment, duration=HOLD, noise={})) for s in sampled]
    names = ("position", "current", "force", "reference")
    return list(simulate_many(pairs, channels=names, rtol=1e-3, progress=False))


def pressed(sampled: Sequence[SampledGrasp], release: float = 0.0) -> list[SampledGrasp]:
    """Grasps limited as the policy limits them in doubt, and let go by `release` [rad]."""
    share = GripSettings().probe_share
    asked = {"touch_share": 0.5, "press_share": share, "touch_delay": 0.04}
    asked = {f"command.{name}": value for name, value in asked.items()}
    free = ran([approaching(each) for each in sampled])
    slowed = [replace(s, values={**s.values, **asked}) for s in sampled]
    made = []
    for each, grasp in zip(limited(slowed, free), free, strict=True):
        times, angles = each.experiment.reference.knots
        since = (times - np.argmax(grasp["force"] > 1.0) / 1e3 - 0.5) / 0.3
        dip = np.where((since > 0.0) & (since < 1.0), 0.5 - 0.5 * np.cos(2.0 * np.pi * since), 0.0)
        reference = Reference([times, angles - release * dip], kinked=False)
        made.append(replace(each, experiment=replace(each.experiment, reference=reference)))
    return made


def seen(current: np.ndarray, position: np.ndarray, rise: float) -> int:
    """Sample from which the touch counts, as recognition finds it by a rise of the current [A]."""
    smooth = np.convolve(current, np.full(10, 0.1))[: current.size]
    begun = int(np.argmax(np.abs(position - position[0]) > 0.05)) + 60
    for now in range(begun + 1, current.size):
        first = max(begun, now - 150)
        least = smooth[first:now].min()
        if smooth[now] > least + rise:
            back = np.flatnonzero(smooth[first : now + 1] <= least + 0.02)
            return first + int(back[-1]) if back.size else first
    return current.size - 800


def traces(grasp: Any, number: int, rise: float) -> np.ndarray:
    """What current [A] and position [rad] did about the touch, in means of 50 ms."""
    noise = np.random.default_rng([7, number]).standard_normal(grasp.time.size)
    current, position = grasp["current"] + 0.01 * noise, grasp["position"]
    touch = min(max(seen(current, position, rise), 170), current.size - 760)
    free = current[touch - 120 : touch - 40].mean()
    speed = 1e3 * np.diff(position[touch - 120 : touch - 40]).mean()
    parts = [slice(touch + k, touch + k + 50) for k in range(-150, 740, 50)]
    columns = [(current[p].mean() - free, position[p].mean() - position[touch]) for p in parts]
    return np.concatenate([(position[touch], free, speed, touch / 1e3), *columns])


def by_polynomial(found: np.ndarray, known: np.ndarray) -> np.ndarray:
    """Errors of log stiffness near the border, cross-validated; `found` (objects, features)."""
    from sklearn.decomposition import PCA
    from sklearn.linear_model import RidgeCV
    from sklearn.pipeline import make_pipeline
    from sklearn.preprocessing import PolynomialFeatures, StandardScaler

    errors, fold = np.zeros(known.size), np.arange(known.size) % 4
    for k in range(4):
        way = make_pipeline(
            StandardScaler(), PCA(12, whiten=True), PolynomialFeatures(2), StandardScaler(),
            RidgeCV(10.0 ** np.arange(-1, 5)),
        )  # fmt: skip
        way.fit(found[fold != k], known[fold != k])
        errors[fold == k] = way.predict(found[fold == k]) - known[fold == k]
    return errors[(known > np.log(NEAR[0])) & (known < np.log(NEAR[1]))]


def in_the_loop(trained_model: str, numbers: Sequence[int]) -> np.ndarray:
    """Errors of log stiffness of trees, observer and networks at the end of a hold, (3, n).

    Those of the networks are NaN where the hand did not press on in doubt.
    """
    errors = []
    for number in numbers:
        stiffness = somewhere(number)
        if not NEAR[0] < stiffness < NEAR[1]:
            continue
        observer, decision, sampled = ForceObserver(), None, put(number, stiffness)
        hand = empty_hand(sampled, model(trained_model))
        loop = GripLoop(model(trained_model), observer=observer, hand=hand)
        board = SimulatedBoard(Disturbed(sampled))
        for said in grasped(board, loop, lambda t: min(SPEED * t, FULL), round(1e3 * HOLD)):
            decision = next((d for each in said for d in each.decisions), decision)
        if decision and decision.stiffness:
            known = decision.pressed.value if decision.pressed and loop.uncertain else np.nan
            said = [decision.stiffness.value, observer.stiffness, known]
            errors.append(np.log(said) - np.log(stiffness))
    return np.array(errors).T


def learned(data: str, parts: Sequence[int]) -> list[Row]:
    """Errors of networks that every so many grasps of the data set trained."""
    given = read(data)
    known = inputs_of(given, model(trained(False)[0]).windowing)
    made = []
    for part in parts:
        some = known.some(slice(None, None, part))
        error = float(fitted(some, float(np.log(given.border)), 0).error[KNOWN])
        made.append(_row(f"networks of {some.target.size} grasps", error))
    return made


def bound(number: int, mean: int = 1) -> float:
    """Least standard deviation of log stiffness [1] at an object of the border's stiffness.

    mean: samples that become one; where more than one, of the traces that the networks have.
    """
    border = spec(SET).border
    (here,) = pressed([put(number, border)])
    names = [n for n in spec(SET).columns if not n.startswith(KEPT)]
    rng, nominal, group = np.random.default_rng(0), spec(SET).hand.parameters, drawn(0, SET).group
    sizes = {"object.stiffness": 0.1 * border}
    for name in names:
        values = [group.distributions[name].value(0, nominal[name], rng) for _ in range(300)]
        sizes.setdefault(name, float(np.std(values)))
    target = here.experiment.object
    at = {**here.hand.parameters, **(target.values if target else {})}
    seen = int(np.argmax(ran([here])[0]["force"] > 1.0))
    ends = [changed(here, n, at[n] + side * STEP * sizes[n]) for n in names for side in (1.0, -1.0)]
    rows = [np.concatenate(_shown(grasp, seen, mean)) for grasp in ran(ends)]
    slopes = (np.array(rows[::2]) - np.array(rows[1::2])) / (2.0 * STEP)
    place, prior = names.index("object.stiffness"), np.eye(len(names))
    prior[place, place] = 1e-4
    return 0.1 * float(np.sqrt(np.linalg.inv(slopes @ slopes.T + prior)[place, place]))


def _shown(grasp: Any, touch: int, mean: int) -> list[np.ndarray]:
    """Current and position over their noise, as samples or as means."""
    pair = [grasp["current"] / NOISE, grasp["position"] / POSITION]
    if mean == 1:
        return pair
    first, last = max(touch - 160, 0), min(touch + 480, 1400)
    first += (last - first) % mean
    cut = np.r_[0:240, first:last]
    return [x[cut].reshape(-1, mean).mean(axis=1) * np.sqrt(mean) for x in pair]


def _row(way: str, errors: np.ndarray | float) -> Row:
    size = float(np.std(errors)) if isinstance(errors, np.ndarray) else errors
    count = errors.size if isinstance(errors, np.ndarray) else 0
    mean = float(np.mean(errors)) if isinstance(errors, np.ndarray) else 0.0
    whole = float(np.hypot(size, mean))
    return {"way": way, "objects": count, "error": size, "mean": mean, "off": 0.8 * PER_LOG * whole}


def measure(quick: bool) -> tuple[list[Row], list[Row]]:
    """A row a way."""
    fewer = QUICK if quick else 1
    numbers = range(FIRST, FIRST + PRESSED // fewer)
    known = np.log([somewhere(k) for k in numbers])
    objects = [put(k, somewhere(k)) for k in numbers]
    plain, again = ran(pressed(objects)), ran(pressed(objects, 0.7))
    path, data = trained(quick)
    said = in_the_loop(path, range(3000, 3000 + 2 * LOOPED // fewer))
    ways = ("trees of the model", "observer of the force", "networks on the traces")
    rows = [_row(way, each[np.isfinite(each)]) for way, each in zip(ways, said, strict=True)]
    rows += [] if quick else learned(data, PARTS)
    for way, grasps, rise in (
        ("polynomial, pressed", plain, 0.06),
        ("polynomial, released and pressed again", again, 0.06),
        ("polynomial, touch from 0.04 A", plain, 0.04),
    ):
        found = np.array([traces(g, k, rise) for g, k in zip(grasps, numbers, strict=True)])
        rows.append(_row(way, by_polynomial(found, known)))
    for name, mean in (("every sample", 1), ("means of 20 ms", 20)):
        least = [bound(k, mean) for k in range(2000, 2000 + (1 if quick else BOUNDED))]
        rows.append(_row(f"bound of Cramer and Rao, {name}", float(np.median(least))))
    return rows, []


if __name__ == "__main__":
    main(__doc__, "grip_ways", measure)
