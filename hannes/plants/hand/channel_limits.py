"""Plausible limits of a hand's channels: wide, so that only a mistake falls outside."""

from collections.abc import Mapping

from hannes.core.recording.channel_limits import Expected

# What was mistaken, and the factor by which the values are then too large.
ANGLE = {"degrees taken for rad": 57.29578, "the motor's side taken for the output's": 19.0}
SIZE = {"thousandths taken for whole units": 1000.0}
SHARE = {"percent taken for a share": 100.0}

EXPECTED: Mapping[str, Expected] = {
    "reference": Expected(peak=(0.2, 40.0), forward=True, mistakes=ANGLE),
    "position": Expected(
        follows="reference", peak=(0.1, 40.0), rate=120.0, lag=0.2, forward=True, mistakes=ANGLE
    ),
    "current": Expected(drives="position", peak=(0.03, 8.0), mistakes=SIZE),
    "duty": Expected(drives="position", peak=(0.02, 1.05), limit=1.0, mistakes=SHARE),
    "supply": Expected(peak=(4.0, 40.0), forward=True, mistakes=SIZE),
    "force": Expected(peak=(0.5, 800.0), forward=True, mistakes=SIZE),
    "sensor": Expected(peak=(0.5, 800.0), mistakes=SIZE),
}
