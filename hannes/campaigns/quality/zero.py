"""A motion that begins, and maybe ends, away from its command: its zero, or a late start."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from hannes.campaigns.quality import mends
from hannes.campaigns.quality.finding import Finding, fault, warning
from hannes.campaigns.quality.law import zero_of
from hannes.campaigns.quality.subject import Subject, speeds
from hannes.core.recording.time_lag import Lag

FloatArray = NDArray[np.float64]

IN_MOTION = 0.15  # of the fastest sustained speed, at the first sample
ENDS = 0.3  # relative, by which a shifted zero may differ at the end
STARTS, AT_ONCE = 5, 5e-3  # samples by which a zero is taken, and the time [s] that they last
LEAST_ZERO = 4e-3  # of its range, that a zero is shifted which a law shows, too
APART = 0.03  # of its range, that a command begins away, and that a zero misleads a fit
STANDS = 0.01  # of its range, that a zero is shifted
GOES_ON = 3  # steps, over which what is under way moves on
PLAUSIBLE = (0.25, 4.0)  # gain of a motion over its command, a blocked one included


def begins_moving(subject: Subject, name: str) -> bool:
    """Whether a motion is under way in the first sample, and goes on: a noisy count does not."""
    speed = subject.speed(name)
    begun, fastest = float(speed[0]), float(np.abs(speed).max())
    goes_on = float(np.mean(speeds(subject.time, subject.recording[name])[:GOES_ON]))
    return fastest > 0.0 and abs(begun) > IN_MOTION * fastest and goes_on / begun > 0.5


def away(subject: Subject, name: str, command: str, lag: Lag) -> Iterator[Finding]:
    """Findings about a motion that follows its command with `lag`, and starts away from it."""
    motion, asked = subject.recording[name], subject.recording[command]
    first = slice(0, max(min(STARTS, round(AT_ONCE / subject.interval)), 1))
    later = np.interp(subject.time - lag.value, subject.time, asked)
    apart = float(np.median(motion[first] - later[first]))
    usual = motion - later
    ends = min(abs(float(each) - apart) for each in (usual[-1], motion[-1] - asked[-1]))
    size, zero = float(np.ptp(asked)), None
    if abs(apart) > LEAST_ZERO * size:
        zero = zero_of(subject, name)
    known = zero is not None and abs(zero - apart) < ENDS * abs(apart)
    shifted = known or ends < ENDS * abs(apart) or _wobbles(usual, apart)
    least = (LEAST_ZERO if known else STANDS if shifted else APART) * size
    if abs(apart) > least and PLAUSIBLE[0] < lag.gain < PLAUSIBLE[1]:
        yield _apart(subject, name, command, apart, shifted)


def _wobbles(usual: FloatArray, apart: float) -> bool:
    """Whether a motion that ends on its way is off by the same at most times."""
    return float(np.median(np.abs(usual - apart))) < 0.5 * ENDS * abs(apart)


def _apart(subject: Subject, name: str, command: str, apart: float, shifted: bool) -> Finding:
    """A motion that starts away from its command, and maybe ends as far from it."""
    mend = mends.shifted(subject, name, -apart)
    text = f"starts {subject.with_unit(apart, name)} away from {command}"
    text += f" and ends as far: its zero is shifted; convert with {mend[0]}" if shifted else (
        ": the recording begins after its command; start the logger earlier")  # fmt: skip
    gross = (
        shifted
        and not begins_moving(subject, name)
        and abs(apart) > APART * float(np.ptp(subject.recording[command]))
    )
    return (fault if gross else warning)(
        "zero" if shifted else "late-start",
        name,
        text,
        time=float(subject.time[0]),
        size=apart,
        mend=mend if shifted else mends.NO_FILE,
    )
