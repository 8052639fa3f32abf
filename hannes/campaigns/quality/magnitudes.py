"""Values too large or too small for their channel: signs of a wrong unit."""

from collections.abc import Iterator

import numpy as np

from hannes.campaigns.quality.finding import Finding, fault, warning
from hannes.campaigns.quality.subject import (
    Subject,
    noise,
    running_median,
    speeds,
    sustained,
)

BACK = 0.3  # of the fastest sustained speed: surely moving
FEWEST = 20  # samples of motion each way
ZERO = 0.02  # of its rms, below zero
LEAST = 0.2  # of its mean forth, that a magnitude has on the way back
CLEAR = 20.0  # peak over noise, above which a small signal is a signal


def inspect(subject: Subject) -> Iterator[Finding]:
    """Findings about the magnitude and the sign of channels whose plausible size is known."""
    for name, expected in subject.expected.items():
        if name not in subject.recording:
            continue
        values = subject.recording[name]
        peak = float(np.abs(values).max())
        low, high = expected.peak
        if peak > high:
            yield _large(subject, name, peak)
        elif 0.0 < peak < low and peak > CLEAR * noise(values):
            yield from _small(subject, name, peak)
        if expected.drives in subject.recording:
            yield from _magnitude(subject, name, expected.drives)
        if expected.forward and values.max() < 0.2 * -values.min() and -values.min() > low:
            yield fault(
                "sign",
                name,
                f"goes down to {subject.with_unit(float(values.min()), name)}, and its positive "
                "direction is the other one: convert with reversed = true",
                size=float(values.min()),
            )


def _magnitude(subject: Subject, name: str, moved: str) -> Iterator[Finding]:
    """Never below zero though the machine is driven back: no sign, or another current."""
    values, time = subject.recording[name], subject.time
    speed = running_median(speeds(time, subject.recording[moved]))
    fast = BACK * sustained(speed)
    back, forth = values[1:][speed < -fast], values[1:][speed > fast]
    if min(back.size, forth.size) < FEWEST:
        return
    least, size = float(values.min()), float(np.sqrt(np.mean(values**2)))
    if least < -ZERO * size - 2.0 * noise(values) or back.mean() < LEAST * forth.mean():
        return
    yield fault(
        "magnitude",
        name,
        f"is never below zero though {moved} is driven back: a magnitude, or the current of the "
        'supply; log it with its sign, or convert with kind = "supply" beside the duty',
        size=float(back.mean()),
    )


def _large(subject: Subject, name: str, peak: float) -> Finding:
    low, high = subject.of(name).peak
    found = f"reaches {subject.with_unit(peak, name)}, far beyond {subject.with_unit(high, name)}"
    fitting = {
        what: factor
        for what, factor in subject.of(name).mistakes.items()
        if low <= peak / factor <= high
    }
    if not fitting:
        return warning("unit", name, f"{found}: check its unit and its scale", size=peak / high)
    ways = " or ".join(f"{what} ({factor:.4g})" for what, factor in fitting.items())
    return fault(
        "unit", name, f"{found}: {ways}? convert with the column's unit", size=min(fitting.values())
    )


def _small(subject: Subject, name: str, peak: float) -> Iterator[Finding]:
    """Too small for what it moves is a fault; alone it may be a light grasp."""
    low, high = subject.of(name).peak
    found = f"reaches only {subject.with_unit(peak, name)}"
    fitting = [f for f in subject.of(name).mistakes.values() if low <= peak * f <= high]
    advice = f"a factor of {fitting[0]:.4g} too small? " if fitting else ""
    moved = subject.of(name).drives
    if moved in subject.recording and np.ptp(subject.recording[moved]) > subject.of(moved).peak[0]:
        text = f"{found} while {moved} moves: {advice}check its unit"
        yield fault("unit", name, text, size=1.0 / fitting[0] if fitting else None)
    elif fitting:
        yield warning("unit", name, f"{found}: {advice}check its unit", size=1.0 / fitting[0])
