"""Whether an estimate of a pressed object's stiffness lacks grasps, or values of hand and object.

Quadratic polynomials of what the model's networks see, fitted to the grasps of the data set `held`
that press on in doubt, within 1.7 times the border of soft and rigid. Errors are of unseen grasps
within 1.5 times of it, one in eight, and of those that were fitted: where both are alike, more
grasps would gain little. Given besides is what the hand showed while it closed on nothing; or the
true values of the hand, the object's other values (size, place, mass, damping, friction), or both,
which no board knows: what they gain is what the traces do not show of them.

off: of forty objects, as in `python -m benchmarks.gripping.ways`.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from benchmarks.grip import trained
from benchmarks.gripping.held import model
from benchmarks.gripping.ways import PER_LOG
from benchmarks.harness import Row, main
from hannes.core.errors import BadInput
from hannes.dataset.read import read
from hannes.recognition.train_pressed import APART, NEAR, inputs_of, other_names

FITTED = 1.7  # factor about the border of the grasps that are fitted
SQUARED, CROSSED = 40, 25  # points of the traces: squared, times what is given besides
QUICK = 4  # times fewer grasps
EXTREME, RIDGE = 3.0, 30.0  # standard deviations of a point at most; of squares, added
OBJECT = ("object.", "floating_object.", "command.")
WAYS = (
    "nothing", "the object's other values", "the hand's empty closure", "the hand", "both"
)  # fmt: skip


@dataclass(frozen=True)
class Pressed:
    """Points of the traces (n, c), log stiffness over the border (n,), other values (n, k).

    hands: what the networks have of the hand's empty closure (n, h); of_object: which of the other
    values are those of the object and its command (k,).
    """

    traces: np.ndarray
    stiffness: np.ndarray
    others: np.ndarray
    hands: np.ndarray
    of_object: np.ndarray

    def of_every(self, part: int) -> "Pressed":
        """One in so many of the grasps."""
        some = [each[::part] for each in (self.traces, self.stiffness, self.others, self.hands)]
        return Pressed(*some, self.of_object)


def pressed() -> Pressed:
    """Grasps of the data set, by the points that the model's networks have of their traces."""
    path, data = trained(False)
    given, trained_model = read(data), model(path)
    known = inputs_of(given, trained_model.windowing)
    networks = trained_model.pressed
    if networks is None:
        raise BadInput(f"{path}: the model has no networks of the stiffness; train it anew")
    traces = _points(known.rows, networks.centre, networks.mix)
    hands = _points(known.hands, networks.hand_centre, networks.hand_mix)
    of_object = np.array([name.startswith(OBJECT) for name in other_names(given)])
    return Pressed(traces, known.target - np.log(given.border), known.others, hands, of_object)


def _points(values: np.ndarray, centre: np.ndarray, mix: np.ndarray) -> np.ndarray:
    """Points of size 1 that networks have of values (n, m), not too far out."""
    points = np.nan_to_num((values[:, : centre.size] - centre) @ mix.T)
    return np.clip(points / points.std(axis=0), -EXTREME, EXTREME)


def terms(traces: np.ndarray, given: np.ndarray) -> np.ndarray:
    """Terms of the polynomial (n, m) of points of the traces and of what is given besides."""
    some = traces[:, :SQUARED]
    first, second = np.triu_indices(some.shape[1])
    parts = [np.ones((len(traces), 1)), traces, some[:, first] * some[:, second]]
    parts += [given, given**2, *(given * some[:, [k]] for k in range(min(some.shape[1], CROSSED)))]
    return np.concatenate(parts, axis=1)


def errors(known: Pressed, given: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Errors of log stiffness near the border of unseen grasps, and of those that were fitted."""
    columns, away = terms(known.traces, given), np.abs(known.stiffness)
    unseen = np.arange(away.size) % APART == 0
    fitted = ~unseen & (away < np.log(FITTED))
    square = columns[fitted].T @ columns[fitted] + RIDGE * np.eye(columns.shape[1])
    weights = np.linalg.solve(square, columns[fitted].T @ known.stiffness[fitted])
    off, near = columns @ weights - known.stiffness, away < np.log(NEAR)
    return off[unseen & near], off[fitted & near]


def rows_of(known: Pressed, ways: Sequence[str] = WAYS) -> list[Row]:
    """A row for each of what is given besides the traces."""
    made, others = [], known.others
    of_object, of_hand = others[:, known.of_object], others[:, ~known.of_object]
    for way, given in zip(
        ways, (others[:, :0], of_object, known.hands, of_hand, others), strict=True
    ):
        unseen, fitted = errors(known, given)
        size = float(np.std(unseen))
        made.append({
            "given besides": way, "grasps": unseen.size, "error": size,
            "of fitted ones": float(np.std(fitted)), "off": 0.8 * PER_LOG * size,
        })  # fmt: skip
    return made


def measure(quick: bool) -> tuple[list[Row], list[Row]]:
    """Rows; there is no bound."""
    known = pressed()
    return rows_of(known.of_every(QUICK) if quick else known), []


if __name__ == "__main__":
    main(__doc__, "gripping.known", measure)
