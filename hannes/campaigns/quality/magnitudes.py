"""Values too large or too small for their channel: signs of a wrong unit."""

from collections.abc import Iterator, Sequence

import numpy as np

from hannes.campaigns.quality import mends
from hannes.campaigns.quality.finding import Finding, fault, warning
from hannes.campaigns.quality.subject import (
    Subject,
    noise,
)

BACK = 0.1  # of the fastest sustained speed: surely moving
FEWEST = 20  # samples of motion each way
ZERO = 0.02  # of its rms, below zero
LEAST = 0.2  # of its mean forth, that a magnitude has on the way back
ENOUGH = 20_000  # samples by which that is judged
BOTH_WAYS = 0.1  # of its largest, that a duty is below zero
FEWEST_DRAWN = 60  # samples from which a supply's current is recognised
CLEARLY, EXPLAINED = 0.4, 0.5  # residual over that of a winding's current, and over its RMS
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
            turned = mends.reversed_sign(subject, name)
            yield fault(
                "sign",
                name,
                f"goes down to {subject.with_unit(float(values.min()), name)}, and its positive "
                f"direction is the other one: convert with {turned[0]}",
                size=float(values.min()),
                mend=turned,
            )


def _magnitude(subject: Subject, name: str, moved: str) -> Iterator[Finding]:
    """Never below zero though the machine is driven back: no sign, or another current."""
    if name == "current" and "duty" in subject.recording and _drawn(subject):
        mend = ('channels.current.kind = "supply"',)
        text = "goes with duty times winding current, as what is drawn from the supply does"
        yield fault("magnitude", name, f"{text}: convert with {mend[0]}", mend=mend)
        return
    values = subject.recording[name]
    speed = subject.speed(moved)
    fast = BACK * float(np.abs(speed).max())
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
        'supply; log it with its sign, convert with kind = "supply" beside the duty, or leave it '
        "out",
        size=float(back.mean()),
        mend=mends.without(subject, name),
    )


def _drawn(subject: Subject) -> bool:
    """Whether a current is explained by duty times that of the winding, and not by the winding's.

    The winding's current is linear in duty, speed and a constant (its resistance, its back EMF);
    times the duty it is what the supply gives.
    """
    from scipy.signal import savgol_filter

    recording = subject.recording
    if "position" not in recording or len(recording) < FEWEST_DRAWN:
        return False
    current, duty = recording["current"], recording["duty"]
    if duty.min() > -BOTH_WAYS * duty.max():
        return False  # of one direction both explain it
    speed = savgol_filter(recording["position"], 21, 2, deriv=1)
    few = slice(None, None, max(duty.size // ENOUGH, 1))
    current, duty, speed = current[few], duty[few], speed[few]
    winding = np.column_stack((duty, speed, np.ones(duty.size)))
    left = [_left(each, current) for each in (winding, duty[:, None] * winding)]
    return left[1] < CLEARLY * left[0] and left[1] < EXPLAINED


def _left(columns: np.ndarray, values: np.ndarray) -> float:
    """Share of a signal's RMS about its mean that columns do not explain."""
    found, *_ = np.linalg.lstsq(columns, values, rcond=None)
    return float(np.std(values - columns @ found) / max(np.std(values), 1e-300))


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
    factor = _nearest(subject, name, list(fitting.values()))
    mend = _mend(subject, name, factor)
    text = f"{found}: {ways}? convert with {mend[0]}"
    return fault("unit", name, text, size=factor, mend=mend)


def _mend(subject: Subject, name: str, factor: float) -> tuple[str, ...]:
    """The line for values that are `factor` times too large."""
    geared = any(f == factor and "side" in what for what, f in subject.of(name).mistakes.items())
    return mends.side(subject, name, factor) if geared else mends.scaled(subject, name, factor)


def _nearest(subject: Subject, name: str, factors: Sequence[float]) -> float:
    """Of several factors the one that makes the motion as long as its command."""
    command = subject.of(name).follows
    asked = subject.recording[command] if command in subject.recording else subject.planned
    if asked is None or np.ptp(asked) == 0.0:
        return min(factors)
    gain = float(np.ptp(subject.recording[name]) / np.ptp(asked))
    return min(factors, key=lambda each: abs(np.log(max(gain, 1e-300) / each)))


def _small(subject: Subject, name: str, peak: float) -> Iterator[Finding]:
    """Too small for what it moves is a fault; alone it may be a light grasp."""
    low, high = subject.of(name).peak
    found = f"reaches only {subject.with_unit(peak, name)}"
    fitting = [f for f in subject.of(name).mistakes.values() if low <= peak * f <= high]
    advice = f"a factor of {fitting[0]:.4g} too small? " if fitting else ""
    moved = subject.of(name).drives
    if moved in subject.recording and np.ptp(subject.recording[moved]) > subject.of(moved).peak[0]:
        text = f"{found} while {moved} moves: {advice}check its unit"
        mend = mends.scaled(subject, name, 1.0 / fitting[0]) if fitting else ()
        size = 1.0 / fitting[0] if fitting else None
        yield fault("unit", name, text, size=size, mend=mend)
    elif fitting:
        mend = mends.scaled(subject, name, 1.0 / fitting[0])
        text = f"{found}: {advice}check its unit"
        yield warning("unit", name, text, size=1.0 / fitting[0], mend=mend)
