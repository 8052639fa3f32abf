"""Lines of a mapping that mend what was found, as TOML.

They go on from what the mapping has already: a scale is multiplied, a sign turned once more, an
offset added to, and stretches are cut beside those that are cut. A line may thus replace the one
that a mapping has of the same key.
"""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from hannes.campaigns.quality.subject import Subject

MOST_CUTS = 60  # stretches that are cut; of more the channel is left out
LEAST_KEPT = 0.05  # share of the samples, from which it is worth to keep what is before a fault
NEAR = 0.1  # relative, of a factor about that of a unit
PREFIXED = {"A": ("mA", "kA"), "V": ("mV", "kV"), "N": ("mN", "kN"), "m": ("mm", "km")}
NO_FILE = ("leave out the file",)


def cut(subject: Subject, runs: Sequence[tuple[int, int]], channel: str = "") -> tuple[str, ...]:
    """Leave out samples, by their first and last index; of too many stretches the channel."""
    if not runs:
        return ()
    if len(runs) > MOST_CUTS:
        return without(subject, channel) if channel else NO_FILE
    time = subject.time
    spans = [*subject.converted.cuts, *((time[a], time[b]) for a, b in runs)]
    pairs = ", ".join(f'["{start:.9g} s", "{end:.9g} s"]' for start, end in spans)
    return (f"time.cut = [{pairs}]",)


def rest(subject: Subject, first: int) -> tuple[str, ...]:
    """Leave out all from a sample on; the file where little would be left."""
    last = len(subject.recording) - 1
    return cut(subject, [(first, last)]) if first > LEAST_KEPT * last else NO_FILE


def scaled(subject: Subject, name: str, factor: float) -> tuple[str, ...]:
    """Take a channel that is `factor` times too large in its right unit."""
    unit, has = subject.recording.units[name], _stated(subject, name)
    small, large = PREFIXED.get(unit, ("", ""))
    known = {180.0 / 3.141592653589793: "deg" if unit == "rad" else "", 1e3: small, 1e-3: large}
    known[100.0] = {"1": "%", "m": "cm"}.get(unit, "")
    moved = _moved(subject, name, 1.0 / factor)
    for size, text in known.items():
        if text and abs(factor / size - 1.0) < NEAR and has.get("unit", unit) == unit:
            return (f'channels.{name}.unit = "{text}"', *moved)
    return (f"channels.{name}.scale = {float(has.get('scale', 1.0)) / factor:.6g}", *moved)


def of_mistake(subject: Subject, name: str, factor: float, mistake: str) -> tuple[str, ...]:
    """Take a channel that is `factor` times too large as the words of a plant's mistake say."""
    way = side if "side" in mistake else scaled
    return way(subject, name, factor)


def side(subject: Subject, name: str, factor: float) -> tuple[str, ...]:
    """An angle before the reducer, so `factor` times too large."""
    if _stated(subject, name).get("side") == "motor":
        return scaled(subject, name, factor)
    return (f'channels.{name}.side = "motor"', *_moved(subject, name, 1.0 / factor))


def reversed_sign(subject: Subject, name: str) -> tuple[str, ...]:
    """The other sign."""
    turned = "false" if _stated(subject, name).get("reversed") else "true"
    return (f"channels.{name}.reversed = {turned}", *_moved(subject, name, -1.0))


def shifted(subject: Subject, name: str, by: float) -> tuple[str, ...]:
    """Another zero: `by` [unit of the channel] is added."""
    offset = _offset(subject, name) + by
    return (f'channels.{name}.offset = "{offset:.6g} {subject.recording.units[name]}"',)


def missing(subject: Subject, codes: Iterable[str]) -> tuple[str, ...]:
    """Texts that stand for no value."""
    texts = dict.fromkeys((*subject.converted.missing, *codes))
    return (f"missing = [{', '.join(f'{_quoted(each)}' for each in texts)}]",)


def rate(subject: Subject, hertz: float) -> tuple[str, ...]:
    """Times by counting samples, from where they begin."""
    first = float(subject.time[0])
    start = (f'time.offset = "{first:.9g} s"',) if first else ()
    return (f'time.sampling = "{hertz:.7g} Hz"', *start)


def without(subject: Subject, name: str) -> tuple[str, ...]:
    """A channel that is of no use; the file where nothing can be judged without it."""
    return NO_FILE if name in subject.needed else (f"leave out channels.{name}",)


def aligned(to: str, shift: float) -> tuple[str, ...]:
    """One clock moved onto the other, by the motion; `shift` [s] is about how far."""
    within = max(2.0 * abs(shift), 1.0)
    return (f'align.to = "{to}"', f'align.within = "{min(within, 3600.0):.3g} s"')


def _stated(subject: Subject, name: str) -> Mapping[str, Any]:
    """What the mapping says of a channel."""
    return subject.converted.stated.get(name, {})


def _offset(subject: Subject, name: str) -> float:
    return subject.converted.scales.get(name, (1.0, 0.0))[1]


def _moved(subject: Subject, name: str, factor: float) -> tuple[str, ...]:
    """An offset that is there, of a channel that is multiplied by `factor`."""
    offset = _offset(subject, name)
    return shifted(subject, name, (factor - 1.0) * offset) if offset else ()


def _quoted(text: str) -> str:
    import json

    return json.dumps(text, ensure_ascii=False)
