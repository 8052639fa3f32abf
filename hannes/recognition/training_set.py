"""Training set: features by window of a data set's grasps, with their true values."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from hannes.core.errors import BadInput
from hannes.core.io.progress import progress_bar
from hannes.dataset.read import BLOCK, DataSet, read
from hannes.recognition.features import CHANNELS
from hannes.recognition.hysteresis_features import grasp_features
from hannes.recognition.model import SINCE, held
from hannes.recognition.windowing import Windowing

WEAKEST = 5.0  # N: an object that was held with less was hardly grasped


@dataclass(frozen=True)
class Grasps:
    """Features (n, windows, features), true values of each grasp, and its force by window [N].

    whole: features of each grasp as a whole, NaN where it is not released or had no contact.
    rigid, scored: which grasps are rigid, which windows are scored; stiffness [N/m], peak [N].
    """

    features: np.ndarray
    whole: np.ndarray
    force: np.ndarray
    rigid: np.ndarray
    stiffness: np.ndarray
    peak: np.ndarray
    scored: np.ndarray

    def released(self) -> np.ndarray:
        """Grasps with a detected contact that were released, ascending."""
        return np.flatnonzero(np.isfinite(self.whole).all(axis=1))

    def some(self, which: np.ndarray) -> "Grasps":
        """Only the grasps `which`: their numbers, or a mask, shape (grasps,)."""
        return Grasps(*(each[which] for each in vars(self).values()))


@dataclass(frozen=True)
class TrainingSet:
    """A data set, and its grasps of the role "train" by a windowing."""

    data: DataSet
    windowing: Windowing
    grasps: Grasps


def training_set(path: str | Path, windowing: Windowing) -> TrainingSet:
    """Read a data set's training grasps; BadInput where there are none, or it is no data set."""
    data = read(path)
    return TrainingSet(data, windowing, grasps(data, data.role("train"), windowing))


def scored(
    times: np.ndarray, windowing: Windowing, contact: np.ndarray, release: np.ndarray
) -> np.ndarray:
    """Which windows lie between contact and release, shape (grasps, windows).

    A feature looks back over two lengths: both must lie inside.
    """
    begun = times - 2.0 * windowing.window
    return (begun >= contact[:, np.newaxis]) & (times <= release[:, np.newaxis])


def grasps(data: DataSet, which: np.ndarray, windowing: Windowing) -> Grasps:
    """Read the grasps `which` (bool); BadInput where there are none."""
    rows = np.flatnonzero(which & data.usable & (data.table["peak_force"] > WEAKEST))
    if not rows.size:
        raise BadInput(f"{data.path}: no grasp of these holds its object")
    rate = 1.0 / float(np.median(np.diff(data.time)))
    if abs(rate / windowing.sampling - 1.0) > 1e-6:
        raise BadInput(f"{data.path}: sampled at {rate:g} Hz, expected {windowing.sampling:g} Hz")
    features, whole, force = [], [], []
    ends = windowing.ends(data.time.size) - 1
    if not ends.size:
        raise BadInput(
            f"a window of {windowing.window:g} s is too long for grasps of "
            f"{np.ptp(data.time):g} s: features look back over two"
        )
    blocks, count = data.blocks(rows, (*CHANNELS, "force")), -(-rows.size // BLOCK)
    for block in progress_bar(
        blocks, "reading grasps", count, delay=2.0, leave=False, disable=None
    ):
        features.append(windowing.features(block[..., :3]))
        whole.append(all_grasp_features(block[..., :3], features[-1], windowing))
        force.append(block[:, ends, 3])
    table = data.table[rows]
    inside = scored(windowing.times(data.time.size), windowing, table["contact"], table["release"])
    known = (data.rigid[rows], table["object.stiffness"], table["peak_force"], inside)
    seen = (np.concatenate(features), np.concatenate(whole), np.concatenate(force))
    return Grasps(*seen, *known)


def all_grasp_features(
    samples: np.ndarray, features: np.ndarray, windowing: Windowing
) -> np.ndarray:
    """Features of whole grasps, as in `of_grasp`, from their samples and those of their windows."""
    last = last_held(features)
    return np.array(
        [grasp_features(*each, windowing) for each in zip(samples, features, last, strict=True)]
    )


def last_held(features: np.ndarray) -> np.ndarray:
    """Last window of each grasp in which its object is held, -1 where there is none."""
    found = held(features)
    last = found.shape[1] - 1 - np.argmax(found[:, ::-1], axis=1)
    return np.where(found.any(axis=1), last, -1)


def decisive(features: np.ndarray) -> np.ndarray:
    """Windows whose class enters a grasp's decision: from the touch to the last one held."""
    places = np.arange(features.shape[1])
    touched = np.nan_to_num(features[..., SINCE]) > 0.0
    return touched & (places <= last_held(features)[:, np.newaxis])
