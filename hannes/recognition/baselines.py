"""Two ways to an object's stiffness without a classifier: the paper argues against both.

Look-up [21, Casini]: the most current so far, by a table of grasps of known objects. The analytic
estimate [22, Deng]: the hand as one joint without friction or inertia. A turn d of the shaft
shortens each of the five wires by r d / 5, turns each finger by r d / (5 a), and squeezes the
object from both sides by s d, with s = 2 L r / (5 a). The wires stretch as springs in series:
1/K = (1/k_leader + 5/k_follower) / r^2. With c = N k_t (rise of current over travel) [N m/rad]
the object has k = 1 / (s^2 (1/c - 1/K)); where c exceeds K it counts as rigid without limit.
Symbols as in docs/explanation/physics.md; L: from the MCP joint to the middle of the last phalanx.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from hannes.core.errors import BadInput
from hannes.recognition.evaluate import CLASSES, Subject, f1, grasp_scope
from hannes.recognition.features import NAMES
from hannes.recognition.model import RIGID, SOFT, held
from hannes.recognition.training_set import Grasps
from hannes.recognition.windowing import Windowing

PEAK, FREE, SECANT = (NAMES.index(n) for n in ("peak_rise", "free_current", "peak_secant"))
MOST = 1e9  # N/m
FINGERS = 5

Estimate = Callable[[np.ndarray], np.ndarray]  # features (m, NAMES) -> stiffness [N/m], shape (m,)


@dataclass(frozen=True)
class LookUp:
    """A table of stiffness [N/m], rising, by the most current so far [A]."""

    current: np.ndarray
    stiffness: np.ndarray

    def __call__(self, features: np.ndarray) -> np.ndarray:
        """Stiffness [N/m] by window, shape (m,)."""
        return np.exp(np.interp(_most(features), self.current, np.log(self.stiffness)))


def look_up(known: Grasps, where_from: object) -> LookUp:
    """The rising table nearest to the scored windows of training grasps (isotonic regression).

    Raises BadInput, naming `where_from`, where no training grasp holds its object.
    """
    from sklearn.isotonic import IsotonicRegression

    where = known.scored & held(known.features)
    if not where.any():
        raise BadInput(f"{where_from}: expected training grasps that hold their object; got none")
    stiffness = np.broadcast_to(known.stiffness[:, np.newaxis], where.shape)[where]
    fitted = IsotonicRegression().fit(_most(known.features[where]), np.log(stiffness))
    return LookUp(fitted.X_thresholds_, np.exp(fitted.y_thresholds_))


def _most(features: np.ndarray) -> np.ndarray:
    """Most motor current so far [A]."""
    return np.asarray(features[:, PEAK] + features[:, FREE], float)


def analytic(values: Mapping[str, float]) -> Estimate:
    """The analytic estimate by a hand's values, names and units as `hannes hand --values`."""
    radius, arm = values["gear.pulley_radius"], values["mcp.moment_arm"]
    length = values["index.second_length"] + 0.5 * values["index.third_length"]
    squeeze = 2.0 * length * radius / (FINGERS * arm)  # m/rad
    stretch = (
        1.0 / values["leader.stiffness"] + FINGERS / values["follower.stiffness"]
    ) / radius**2
    torque = values["gear.ratio"] * values["motor.torque_constant"]  # N m/A

    def stiffness(features: np.ndarray) -> np.ndarray:
        rise = np.maximum(torque * features[:, SECANT].astype(float), 1e-9)
        softness = squeeze**2 * (1.0 / rise - stretch)  # m/N
        return 1.0 / np.maximum(softness, 1.0 / MOST)

    return stiffness


def baseline_scores(
    estimate: Estimate, windowing: Windowing, border: float, subjects: Sequence[Subject]
) -> dict[str, Any]:
    """Scores as those of `evaluate`: rows by object, `f1_windows`, `f1_grasps`."""
    rows = [_row(estimate, windowing, border, each) for each in subjects]
    means = {key: float(np.mean([row[key] for row in rows])) for key in ("f1_windows", "f1_grasps")}
    return {"objects": rows, **means}


def _row(
    estimate: Estimate, windowing: Windowing, border: float, subject: Subject
) -> dict[str, Any]:
    """An object's name, class and scores; without a contact a window counts as soft."""
    windows, grasps = [], []
    for recording in subject.recordings:
        features = windowing.features(windowing.samples(recording)[np.newaxis])[0]
        holds = held(features)
        label = np.where(holds & (estimate(features) >= border), RIGID, SOFT)
        times = recording.time[0] + windowing.times(len(windowing.samples(recording)))
        windows.append(label[grasp_scope(subject, recording, windowing, times)] == subject.label)
        last = int(np.flatnonzero(holds)[-1]) if holds.any() else None
        grasps.append(last is not None and label[last] == subject.label)
    return {
        "name": subject.name,
        "class": CLASSES[subject.label],
        "f1_windows": f1(float(np.mean(np.concatenate(windows)))),
        "f1_grasps": f1(float(np.mean(grasps))),
    }
