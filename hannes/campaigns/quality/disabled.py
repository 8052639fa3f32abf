"""A drive that was switched off within a run: no drive while the command goes on."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from hannes.campaigns.quality import mends
from hannes.campaigns.quality.finding import Finding, fault
from hannes.campaigns.quality.subject import Subject, noise, quantum, true_runs

FloatArray = NDArray[np.float64]

NOTHING = 0.03  # of the largest drive: none, within noise
ACTIVE = 0.25  # of the largest drive, from which it was enabled
SHORTEST = 6  # samples without any drive
ASKED = 0.1  # of its range, that the command moves meanwhile
STILL = 0.3  # of the command's move, that the machine makes meanwhile


def inspect(subject: Subject) -> Iterator[Finding]:
    """Stretches without drive, in which the machine stands and its command does not."""
    recording = subject.recording
    drives = [n for n, each in subject.expected.items() if each.drives and n in recording]
    moved = next((n for n, each in subject.expected.items() if each.follows and n in recording), "")
    asked = _command(subject, moved)
    if not drives or not moved or asked is None or np.ptp(asked) == 0.0:
        return
    off = np.all([_idle(recording[name]) for name in drives], axis=0)
    used = np.any([_used(recording[name]) for name in drives], axis=0)
    runs = [
        each
        for each in true_runs(off)
        if used[each[0]]
        and _behind(recording[moved], asked, *each)
        and not any(_same(recording[name], *each) for name in drives)
    ]
    if not runs:
        return
    first = runs[0][0]
    lasting = float(sum(subject.time[b] - subject.time[a] for a, b in runs))
    yield fault(
        "disabled",
        drives[0],
        f"is zero for {lasting:.3g} s from {subject.time[first]:.4g} s on while the command goes "
        f"on and {moved} stands: the drive was switched off; leave that out (time.cut)",
        time=float(subject.time[first]),
        size=lasting,
        mend=mends.cut(subject, [(first, len(recording) - 1)]),
    )


def _command(subject: Subject, moved: str) -> FloatArray | None:
    command = subject.of(moved).follows if moved else ""
    if command in subject.recording:
        return subject.recording[command]
    if subject.plan is None:
        return None
    return np.interp(subject.time, subject.plan.times, subject.plan.values)


def _idle(values: FloatArray) -> NDArray[np.bool_]:
    """Where a drive does nothing, but for its noise."""
    from scipy.ndimage import median_filter

    band = max(NOTHING * float(np.abs(values).max()), 4.0 * noise(values), quantum(values))
    return np.asarray(np.abs(median_filter(values, 3, mode="nearest")) <= band)


def _same(values: FloatArray, first: int, last: int) -> bool:
    """Whether a noisy channel does not even show its noise: its sensor stands, not the drive."""
    return noise(values) > 0.0 and float(np.ptp(values[first : last + 1])) == 0.0


def _used(values: FloatArray) -> NDArray[np.bool_]:
    """Whether the drive has been active before each sample: it was enabled."""
    return np.asarray(np.maximum.accumulate(np.abs(values)) > ACTIVE * np.abs(values).max())


def _behind(motion: FloatArray, asked: FloatArray, first: int, last: int) -> bool:
    """Whether the command moves on in a stretch and the machine does not."""
    if last - first + 1 < SHORTEST:
        return False
    part = slice(first, last + 1)
    goes, made = float(np.ptp(asked[part])), float(np.ptp(motion[part]))
    return goes > ASKED * float(np.ptp(asked)) and made < STILL * goes
