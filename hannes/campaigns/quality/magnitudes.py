"""Values too large or too small for their channel: signs of a wrong unit."""

from collections.abc import Iterator

import numpy as np

from hannes.campaigns.quality.finding import Finding, fault, warning
from hannes.campaigns.quality.subject import Subject, noise

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
        if expected.forward and values.max() < 0.2 * -values.min() and -values.min() > low:
            yield fault(
                "sign",
                name,
                f"goes down to {subject.with_unit(float(values.min()), name)}, and its positive "
                "direction is the other one: convert with reversed = true",
                size=float(values.min()),
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
