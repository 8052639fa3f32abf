"""A hand that is known: what it showed while it closed on nothing, before its first grasp.

Slack, loss of the gear, friction and the motor's constant differ from hand to hand, and the traces
of a grasp do not separate them from the object. An empty closure (`hannes record empty-closure`)
shows them almost wholly.
"""

import numpy as np

from hannes.core.errors import BadInput
from hannes.core.recording.recording import Recording
from hannes.dataset.empty_closure import MEAN, empty_means, mean_size
from hannes.recognition.model import Model
from hannes.recognition.pressed import KNOWN, UNKNOWN

BEGUN = 1e-3  # rad by which the command has moved once it has begun
APART = 2.5e-3  # s between samples, one lost of 1 kHz: lines over more of them show another hand
ANEW = "see what `hannes port` says of the link, and record the closure anew"
START = 0.0  # rad, where the command of `empty-closure` begins


def hand_numbers(recording: Recording, model: Model) -> np.ndarray:
    """Numbers (n,) of a recorded empty closure, by which `model` knows the hand.

    They are means of current [A], then of lag [rad], each of 20 ms from the command's start on.
    Raises BadInput where the model knows no hands, or the recording is no such closure, is sampled
    at less than 400 Hz, or lacks samples.
    """
    numbers = model.pressed.hand_centre.size if model.pressed else 0
    sampling = model.windowing.sampling
    size = mean_size(sampling)
    if not numbers or not size:
        raise BadInput(
            "the model has learned nothing of empty closures; train it anew on a data set that has "
            "them, `held` for instance"
        )
    current, position, reference = model.windowing.samples(recording).T
    begun = np.flatnonzero(np.abs(reference - reference[0]) > BEGUN)
    first = max(int(begun[0]) - 1, 0) if begun.size else 0
    last = first + numbers // 2 * size - 1
    if last >= reference.size:
        raise BadInput(
            f"the empty closure is too short: expected {numbers / 2 * MEAN:g} s from its start on, "
            "by the command of `empty-closure`"
        )
    _require_start(reference, sampling)
    _require_whole(recording.time, first / sampling, last / sampling)
    found = empty_means(current[first:], position[first:], reference[first:], size, numbers)
    return checked(found, model)


def _require_start(reference: np.ndarray, sampling: float) -> None:
    """Raise BadInput where the command (n,) [rad] is under way at the first sample.

    What a clock says there is no matter: recordings of other programs begin at any time.
    """
    step = abs(reference[1] - reference[0])
    beyond, speed = abs(reference[0] - START), step * sampling
    if step > BEGUN and beyond > APART * speed:
        raise BadInput(
            f"the empty closure begins with its command at {reference[0]:.3g} rad already: "
            f"{beyond / speed:.3f} s are missing; expected all from its start at {START:g} rad on; "
            f"{ANEW}"
        )


def _require_whole(time: np.ndarray, begin: float, end: float) -> None:
    """Raise BadInput where samples are missing between `begin` and `end` [s] from the first on."""
    since, apart = time - time[0], np.diff(time)
    inside = (since[1:] > begin) & (since[:-1] < end)
    usual = float(np.median(apart[inside]))
    if usual > APART:
        raise BadInput(
            f"the empty closure is sampled too slowly, at {1.0 / usual:.0f} Hz: expected at least "
            f"{1.0 / APART:.0f} Hz; record it anew at 1 kHz"
        )
    far = np.flatnonzero((apart > APART) & inside)
    if far.size:
        start, end = time[far[0]], time[far[0] + 1]
        raise BadInput(
            f"the empty closure has a gap of {1e3 * (end - start):.0f} ms, from {start:.3f} s on: "
            f"expected samples at most {1e3 * APART:g} ms apart; {ANEW}"
        )


def unknown_hand(model: Model) -> str:
    """What to say where a model knows hands, and this one is not known; "" where it knows none."""
    known = model.pressed
    if known is None or not known.hand_centre.size:
        return ""
    without, with_it = (100.0 * known.error[k] for k in (UNKNOWN, KNOWN))
    return (
        f"the hand is not known, and counts as a middle one: stiffness near the border is off by "
        f"{without:.1f} %, by {with_it:.1f} % after an empty closure (--empty)"
    )


def checked(numbers: np.ndarray, model: Model) -> np.ndarray:
    """The numbers, where `model` has learned from hands like this; BadInput otherwise."""
    points_of(numbers, model)
    return numbers


def points_of(numbers: np.ndarray, model: Model) -> np.ndarray:
    """What the networks see of the numbers, where `checked` gives these."""
    known = model.pressed
    if known is None:
        raise BadInput("the model knows no hands: it has no networks of the stiffness")
    if (points := known.points(numbers)) is None:
        raise BadInput(
            "the empty closure is unlike all that the model learned from: was something held, was "
            "it another command than that of `empty-closure`, or is it another kind of hand?"
        )
    return points
