"""What a page says of a recording and of the simulation that draws it."""

import numpy as np

from hannes.report.viewer.replay import Replay
from hannes.report.viewer.scene import Scene

COMPARED = ("position", "current")
GROSS = 0.3  # RMS of what is missed over the range of the motion: not the same motion


def notes(shown: Replay, made: Scene, file: str, named: str = "") -> str:
    """One line: where the recording is from, what draws it, how far that is from it.

    file: the recording's, for the next command; named: the experiment that the user named for it.
    """
    if made.own:
        said = ["simulated"]
    else:
        said = [f"{shown.recording.source}; {_drawn(shown, made, named)}", *_apart(shown, file)]
    effects = [each.name for each in shown.hand.present_effects()]
    said += [f"with {', '.join(effects)}"] if effects else []
    if made.every > 1:
        count = len(shown.recording)
        said.append(f"one of {made.every} samples of {count} is shown, and the last")
    return "; ".join(said)


def _drawn(shown: Replay, made: Scene, named: str) -> str:
    """Which simulation draws a recording, and from what it was taken."""
    experiment = shown.experiment
    if named or shown.recording.experiment:
        thing = f"a {experiment.shape}" if experiment.shape else "no object"
        under = f'"{experiment.title}" ({thing})'
    else:
        under = (
            "a free closure without an object, which is assumed (the recording does not say what "
            "was done: --experiment NAME does)"
        )
    hand = made.drawn_by or "its own hand"
    if "reference" in shown.recording:
        driven = "driven by the recorded reference"
    elif shown.aligned:
        driven = f"begun at {shown.start:.3g} s, where the positions agree best"
    else:
        driven = f"begun at {shown.start:.4g} s"
    return (
        f"it has no joint angles, so a simulation draws it: {hand} under {under}, {driven}, "
        "nothing fitted"
    )


def _apart(shown: Replay, file: str) -> list[str]:
    """How far the simulation is from what was recorded, and what to do where that is gross."""
    known = [each for each in COMPARED if each in shown.recording]
    if not known:
        return ["no position or current to compare"]
    said = [
        f"{each} within {shown.gap(each):.2g} {shown.recording.units[each]} RMS" for each in known
    ]
    if far := gross(shown):
        named = f"`hannes check {file}` says what may be wrong with it"
        if not shown.recording.experiment:
            named = f"what was gripped? name it with --experiment; {named}"
        said.append(f"THE SIMULATED {' AND '.join(far).upper()} IS FAR FROM THE RECORDED: {named}")
    return said


def gross(shown: Replay) -> list[str]:
    """Channels of which the simulation is far from the recorded, by the larger of both ranges."""
    found = []
    for name in COMPARED:
        if name in shown.recording:
            both = (shown.recording[name], shown.trajectory[name])
            if shown.gap(name) > GROSS * max(float(np.ptp(each)) for each in both):
                found.append(name)
    return found
