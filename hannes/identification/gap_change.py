"""Whether another simulation is nearer to recordings that were not fitted, or farther.

Let u be the difference of two simulations and e how a run differs from its repeats. The sum of
squared residuals then changes by what u predicts, and by chance as 2 u'e does from run to run. That
is measured with the repeats themselves, so noise of any colour and whatever differs between runs
count as they are. A run without repeats is taken to differ by the noise floor, the same over each
of the plant's blocks of time: more than it likely does.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from hannes.campaigns.segments import Segment
from hannes.plants.protocol import Plant

LEVEL = 0.01  # one-sided, over all channels together
FALL_LEVEL = 0.05  # the same of a fall: what is right must seldom miss it
WIDE = 6.0  # standard deviations: a quantile beyond it sees only gross changes
SURELY = 2.33  # standard deviations: what is right would be missed once in a hundred
ASSUMED = 1000.0  # degrees of freedom where a run has no repeats

Raw = Sequence[Mapping[str, np.ndarray]]


@dataclass(frozen=True)
class GapChange:
    """Of one channel [its unit]: RMS residual before and after, and the squares' change.

    rise:     sum of squares after less before;  expected: were the simulation after it right
    spread:   standard deviation of the rise from run to run
    quantile: of its distribution, in such standard deviations, at the level of a rise
    fall_quantile: the same at the level of a fall
    """

    channel: str
    unit: str
    before: float
    after: float
    rise: float
    expected: float
    spread: float
    quantile: float
    fall_quantile: float

    @property
    def worse(self) -> bool:
        """Whether the gap rises by more than runs differ by."""
        return self.rise > self.quantile * self.spread

    @property
    def better(self) -> bool:
        """Whether it falls beyond chance."""
        return self.rise < -self.fall_quantile * self.spread

    @property
    def could_show(self) -> bool:
        """Whether the fall would surely be seen, were the simulation after it right."""
        return self.expected < -(self.quantile + SURELY) * self.spread

    @property
    def text(self) -> str:
        """`that of the current from 0.012 to 0.071 A`."""
        unit = "" if self.unit == "1" else f" {self.unit}"
        return f"that of the {self.channel} from {self.before:.3g} to {self.after:.3g}{unit}"


def gap_changes(
    plant: Plant,
    segments: Sequence[Segment],
    unfitted: Sequence[Segment],
    before: Raw,
    after: Raw,
    noise_floors: Mapping[str, float],
) -> list[GapChange]:
    """The change of each channel over `unfitted`, some of all `segments`; see above.

    before, after: simulated minus recorded of each unfitted segment
    """
    names = [n for n in plant.judged if any(n in each for each in before)]
    if not unfitted:
        return []
    count = max(1, len(names))
    return [
        _change(plant, segments, unfitted, (before, after), name, noise_floors[name], count)
        for name in names
    ]


def _change(
    plant: Plant,
    segments: Sequence[Segment],
    unfitted: Sequence[Segment],
    raws: tuple[Raw, Raw],
    name: str,
    noise_floor: float,
    count: int,
) -> GapChange:
    from scipy.stats import t

    pairs = [(s, b[name], a[name]) for s, b, a in zip(unfitted, *raws, strict=True)
             if name in b]  # fmt: skip
    chances = _chances(plant, segments, pairs, name, noise_floor)
    freedom = _freedom(chances)
    old, new = (np.concatenate([pair[k] for pair in pairs]) for k in (1, 2))
    return GapChange(
        name,
        plant.channels[name],
        float(np.sqrt(np.mean(old**2))),
        float(np.sqrt(np.mean(new**2))),
        float(new @ new - old @ old),
        -float((new - old) @ (new - old)),
        float(np.sqrt(sum(variance for variance, _ in chances))),
        *(float(t.ppf(1.0 - level / count, freedom)) for level in (LEVEL, FALL_LEVEL)),
    )


def _chances(
    plant: Plant,
    segments: Sequence[Segment],
    pairs: Sequence[tuple[Segment, np.ndarray, np.ndarray]],
    name: str,
    noise_floor: float,
) -> list[tuple[float, float]]:
    """Variance of the rise by chance, and its degrees of freedom, of each command's runs.

    Runs under one command share the error of the mean that was fitted.
    """
    found: list[tuple[float, float]] = []
    alike: dict[tuple[object, ...], list[tuple[Segment, np.ndarray]]] = {}
    for segment, was, now in pairs:
        alike.setdefault(_key(plant, segment), []).append((segment, now - was))
    for some in alike.values():
        first, moved = some[0]
        repeats = _repeats(plant, segments, first, name)
        if len(repeats) < 2:
            found.append((_assumed(plant, first, moved, noise_floor), ASSUMED))
        else:
            fitted = len(repeats) - len(some)
            times = len(some) * (1.0 + (len(some) / fitted if fitted else 0.0))
            found.append((times * _variance(repeats, moved), len(repeats) - 1.0))
    return found


def _freedom(chances: Sequence[tuple[float, float]]) -> float:
    """Degrees of freedom of a sum of variances (Welch 1947; Satterthwaite 1946)."""
    whole = sum(variance for variance, _ in chances)
    if not whole:
        return min((freedom for _, freedom in chances), default=ASSUMED)
    return 1.0 / sum((variance / whole) ** 2 / freedom for variance, freedom in chances)


def _repeats(plant: Plant, segments: Sequence[Segment], of: Segment, name: str) -> list[np.ndarray]:
    """Counted samples of a channel in a segment's repeats, itself among them."""
    key = _key(plant, of)
    return [
        each.recording[name][of.mask]
        for each in segments
        if name in each.recording and _key(plant, each) == key
    ]


def _key(plant: Plant, segment: Segment) -> tuple[object, ...]:
    """Equal for segments that repeat each other."""
    return segment.entry.condition, plant.same_run(segment.recording), segment.mask.tobytes()


def _assumed(plant: Plant, segment: Segment, moved: np.ndarray, noise_floor: float) -> float:
    """Variance of 2 u'e of a run without repeats, e as large as the floor throughout a block."""
    since = segment.recording.time[segment.mask] - segment.recording.time[0]
    blocks = np.bincount((since / plant.block).astype(int), np.abs(moved))
    return 4.0 * noise_floor**2 * float(blocks @ blocks)


def _variance(repeats: Sequence[np.ndarray], moved: np.ndarray) -> float:
    """Variance of 2 u'e between runs."""
    return float(np.var([2.0 * float(moved @ each) for each in repeats], ddof=1))


def hardly_tested(changes: Sequence[GapChange]) -> str:
    """What repeats too few to see a rise leave open, in words, or an empty string."""
    widest = max((each.quantile for each in changes), default=0.0)
    if widest <= WIDE:
        return ""
    return (
        "few repeats say how far runs differ: on recordings that were not fitted only a rise of "
        f"the gap beyond {widest:.2g} standard deviations could be seen, at {LEVEL:g} over all "
        "channels"
    )


def worsened(changes: Sequence[GapChange]) -> str:
    """The gaps that rise by more than runs differ by, in words; empty where none does."""
    return " and ".join(each.text for each in changes if each.worse)


def lacks_gain(changes: Sequence[GapChange]) -> bool:
    """Whether no gap falls beyond chance though one would show it, were the simulation right."""
    shown = any(each.better for each in changes)
    return not shown and any(each.could_show for each in changes)


def refusal(changes: Sequence[GapChange]) -> str:
    """Why what made this change is not taken, or an empty string."""
    if why := refused_rise(changes):
        return why
    if lacks_gain(changes):
        return "on recordings that were not fitted no gap falls by more than runs differ by"
    return ""


def refused_rise(changes: Sequence[GapChange]) -> str:
    """The same where no gap need fall."""
    worse = worsened(changes)
    return f"on recordings that were not fitted it raises the gap, {worse}" if worse else ""


def too_faint(changes: Sequence[GapChange]) -> bool:
    """Whether no fall could surely have shown in these recordings."""
    return not any(each.better or each.could_show for each in changes)
