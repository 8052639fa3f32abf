"""A motion sensor that shows the drive's current: both wires share a ground, or lie side by side.

What changes from sample to sample in a machine's motion is the sensor's own noise and rounding,
and the drive's is its own. Where the two are the same but for a factor, at no delay in either
direction, one leaks into the other. A controller that answers to its sensor's noise makes them
alike too, but later, or it is exactly its error times a gain.
"""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from hannes.campaigns.quality import mends
from hannes.campaigns.quality.finding import Finding, fault
from hannes.campaigns.quality.subject import Subject, noise, quantum

FloatArray = NDArray[np.float64]

SAME = 0.9  # correlation of second differences, from which two channels are one
EVEN = 0.1  # by which those a sample earlier and later may differ
FEWEST = 200  # samples
MOST = 20_000  # samples that are enough
CLIPPED = 4.0  # median sizes, at which single large changes are cut off
LITTLE = 0.01  # of the motion, that leaks against the drive's sign
ROUNDED = 0.5  # quantisation steps that the leaking part has at least, in standard deviations
# Steps of both, and share of the drive, to which a controller that answers is exact.
DIGITS, EXACT = 2.0, 1e-3


def inspect(subject: Subject) -> Iterator[Finding]:
    """Motions that carry the noise of their drive."""
    recording = subject.recording
    for name, expected in subject.expected.items():
        moved = expected.drives
        if name not in recording or moved not in recording or len(recording) < FEWEST:
            continue
        drive, motion = recording[name][:MOST], recording[moved][:MOST]
        rough = noise(recording[name])
        if rough == 0.0 or not _alike(drive, motion):
            continue
        share = _share(drive, motion)
        if abs(share) * rough < ROUNDED * quantum(recording[moved]):
            continue
        if share < 0.0 and _answers(subject, name, moved, share):
            continue
        leaks = abs(share) * float(np.ptp(recording[name]))
        if share < 0.0 and leaks < LITTLE * float(np.ptp(recording[moved])):
            continue  # a controller that answers to its sensor's noise looks the same
        yield fault(
            "crosstalk",
            moved,
            f"changes from sample to sample as {name} does, by up to "
            f"{subject.with_unit(leaks, moved)}: {name} leaks into its sensor, by a ground or "
            f"a cable that they share; mend the wiring, or leave {moved} out",
            size=share,
            mend=mends.without(subject, moved),
        )


def _changes(values: FloatArray) -> FloatArray:
    """Second differences, with single large ones cut off."""
    second = np.diff(values, 2)
    most = CLIPPED * float(np.median(np.abs(second)))
    return np.clip(second, -most, most)


def _alike(drive: FloatArray, motion: FloatArray) -> bool:
    a, b = _changes(motion), _changes(drive)
    size = float(np.sqrt((a @ a) * (b @ b)))
    if size == 0.0:
        return False
    same, later, earlier = (float(x) / size for x in (a @ b, a[1:] @ b[:-1], a[:-1] @ b[1:]))
    return abs(same) > SAME and abs(later - earlier) < EVEN


def _share(drive: FloatArray, motion: FloatArray) -> float:
    """Motion per drive, of what changes from sample to sample."""
    a, b = np.diff(motion, 2), np.diff(drive, 2)
    return float(a @ b) / float(b @ b)


def _answers(subject: Subject, name: str, moved: str, share: float) -> bool:
    """Whether the drive is the error times the gain that its changes show, to their last digit."""
    asked, motion = subject.asked_of(moved), subject.recording[moved]
    if asked is None:
        return False
    drive = subject.recording[name]
    left = drive - (asked - motion) / -share
    steps = quantum(drive) + quantum(motion) / -share
    return float(np.std(left)) < max(DIGITS * steps, EXACT * float(np.std(drive)))
