"""Where effects join written equations: a call that the compiler replaces by theirs."""

from typing import Any


def effects(*channels: Any) -> Any:
    """Return the channels as they are: what equations do as plain Python, without any effect.

    `a, b = effects(a, b)` opens two channels of a stage; compiled, the calls of the effects that
    add to them stand there.
    """
    return channels[0] if len(channels) == 1 else channels


open_to_effects = effects  # as a user's equations have it: `hannes.effects` is the catalogue
