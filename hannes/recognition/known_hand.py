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


def hand_numbers(recording: Recording, model: Model) -> np.ndarray:
    """Numbers (n,) of a recorded empty closure, by which `model` knows the hand.

    They are means of current [A], then of lag [rad], each of 20 ms from the command's start on.
    Raises BadInput where the model knows no hands, or the recording is no such closure.
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
    if reference.size - first < numbers // 2 * size:
        raise BadInput(
            f"the empty closure is too short: expected {numbers / 2 * MEAN:g} s from its start on, "
            "by the command of `empty-closure`"
        )
    found = empty_means(current[first:], position[first:], reference[first:], size, numbers)
    return checked(found, model)


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
    known = model.pressed
    if known is None:
        raise BadInput("the model knows no hands: it has no networks of the stiffness")
    if known.points(numbers) is None:
        raise BadInput(
            "the empty closure is unlike all that the model learned from: was something held, was "
            "it another command than that of `empty-closure`, or is it another kind of hand?"
        )
    return numbers
