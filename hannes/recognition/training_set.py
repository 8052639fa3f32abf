"""Grasps of a data set as training takes them: features by window, and what is known of them."""

from dataclasses import dataclass

import numpy as np
from tqdm import tqdm

from hannes.core.errors import BadInput
from hannes.dataset.read import BLOCK, DataSet
from hannes.recognition.features import CHANNELS
from hannes.recognition.hysteresis_features import of_grasp
from hannes.recognition.model import held
from hannes.recognition.windowing import Cut

WEAKEST = 5.0  # N: an object that was held with less was hardly grasped


@dataclass(frozen=True)
class Grasps:
    """Features (n, windows, features), what is known of each grasp, and its force by window [N].

    whole: features of each grasp as a whole, NaN where it is not let go or never felt.
    """

    features: np.ndarray
    whole: np.ndarray
    force: np.ndarray
    rigid: np.ndarray
    stiffness: np.ndarray
    peak: np.ndarray
    scored: np.ndarray

    def let_go(self) -> np.ndarray:
        """Which grasps were felt and let go, ascending."""
        return np.flatnonzero(np.isfinite(self.whole).all(axis=1))

    def some(self, which: np.ndarray) -> "Grasps":
        """Only the grasps `which`: their numbers, or a mask, shape (grasps,)."""
        return Grasps(*(each[which] for each in vars(self).values()))


def scored(times: np.ndarray, cut: Cut, contact: np.ndarray, release: np.ndarray) -> np.ndarray:
    """Which windows lie between contact and release, shape (grasps, windows).

    A feature looks back over two lengths: both must lie inside.
    """
    begun = times - 2.0 * cut.window
    return (begun >= contact[:, np.newaxis]) & (times <= release[:, np.newaxis])


def grasps(data: DataSet, which: np.ndarray, cut: Cut) -> Grasps:
    """Read the grasps `which` (bool); BadInput where there are none."""
    rows = np.flatnonzero(which & data.usable & (data.table["peak_force"] > WEAKEST))
    if not rows.size:
        raise BadInput(f"{data.path}: no grasp of these holds its object")
    rate = 1.0 / float(np.median(np.diff(data.time)))
    if abs(rate / cut.sampling - 1.0) > 1e-6:
        raise BadInput(f"{data.path}: sampled at {rate:g} Hz, expected {cut.sampling:g} Hz")
    features, whole, force = [], [], []
    ends = cut.ends(data.time.size) - 1
    if not ends.size:
        raise BadInput(
            f"a window of {cut.window:g} s is too long for grasps of {np.ptp(data.time):g} s: "
            "features look back over two"
        )
    blocks, count = data.blocks(rows, (*CHANNELS, "force")), -(-rows.size // BLOCK)
    for block in tqdm(blocks, "reading grasps", count, delay=2.0, leave=False, disable=None):
        features.append(cut.features(block[..., :3]))
        whole.append(wholes(block[..., :3], features[-1], cut))
        force.append(block[:, ends, 3])
    table = data.table[rows]
    inside = scored(cut.times(data.time.size), cut, table["contact"], table["release"])
    known = (data.rigid[rows], table["object.stiffness"], table["peak_force"], inside)
    seen = (np.concatenate(features), np.concatenate(whole), np.concatenate(force))
    return Grasps(*seen, *known)


def wholes(samples: np.ndarray, features: np.ndarray, cut: Cut) -> np.ndarray:
    """Features of whole grasps, as in `of_grasp`, from their samples and those of their windows."""
    last = last_held(features)
    return np.array([of_grasp(*each, cut) for each in zip(samples, features, last, strict=True)])


def last_held(features: np.ndarray) -> np.ndarray:
    """Last window of each grasp in which its object is held, -1 where there is none."""
    found = held(features)
    last = found.shape[1] - 1 - np.argmax(found[:, ::-1], axis=1)
    return np.where(found.any(axis=1), last, -1)
