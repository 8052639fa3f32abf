"""Lines of a mapping that mend what was found, as TOML."""

from collections.abc import Sequence

from hannes.campaigns.quality.subject import Subject

MOST_CUTS = 60  # stretches that are cut; of more the channel is left out
NEAR = 0.1  # relative, of a factor about that of a unit
PREFIXED = {"A": ("mA", "kA"), "V": ("mV", "kV"), "N": ("mN", "kN"), "m": ("mm", "km")}


def cut(subject: Subject, runs: Sequence[tuple[int, int]], channel: str = "") -> tuple[str, ...]:
    """Leave out samples, by their first and last index; of too many stretches the channel."""
    if not runs:
        return ()
    if len(runs) > MOST_CUTS:
        return (f"leave out channels.{channel}",) if channel else ("leave out the file",)
    time = subject.time
    pairs = ", ".join(f'["{time[a]:.9g} s", "{time[b]:.9g} s"]' for a, b in runs)
    return (f"time.cut = [{pairs}]",)


def scaled(subject: Subject, name: str, factor: float) -> tuple[str, ...]:
    """Take a channel that is `factor` times too large in its right unit."""
    unit = subject.recording.units[name]
    small, large = PREFIXED.get(unit, ("", ""))
    known = {180.0 / 3.141592653589793: "deg" if unit == "rad" else "", 1e3: small, 1e-3: large}
    known[100.0] = {"1": "%", "m": "cm"}.get(unit, "")
    for size, text in known.items():
        if text and abs(factor / size - 1.0) < NEAR:
            return (f'channels.{name}.unit = "{text}"',)
    return (f"channels.{name}.scale = {1.0 / factor:.6g}",)


def side(name: str) -> tuple[str, ...]:
    """An angle before the reducer."""
    return (f'channels.{name}.side = "motor"',)


def reversed_sign(name: str) -> tuple[str, ...]:
    """The other sign."""
    return (f"channels.{name}.reversed = true",)


def rate(hertz: float) -> tuple[str, ...]:
    """Times by counting samples."""
    return (f'time.sampling = "{hertz:.7g} Hz"',)


def without(name: str) -> tuple[str, ...]:
    """A channel that is of no use."""
    return (f"leave out channels.{name}",)


def aligned(to: str, shift: float) -> tuple[str, ...]:
    """One clock moved onto the other, by the motion; `shift` [s] is about how far."""
    within = max(2.0 * abs(shift), 1.0)
    return (f'align.to = "{to}"', f'align.within = "{min(within, 3600.0):.3g} s"')


NO_FILE = ("leave out the file",)
