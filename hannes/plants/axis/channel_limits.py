"""Plausible limits of the axis' channels: wide, so that only a mistake falls outside."""

from collections.abc import Mapping

from hannes.core.recording.channel_limits import Expected

MOTION = {"mm taken for m": 1000.0, "cm taken for m": 100.0}

EXPECTED: Mapping[str, Expected] = {
    "reference": Expected(peak=(1e-3, 5.0), mistakes=MOTION),
    "position": Expected(
        follows="reference", peak=(1e-3, 5.0), rate=20.0, lag=0.1, mistakes=MOTION
    ),
    "drive": Expected(drives="position", peak=(0.01, 30.0), mistakes={"mV taken for V": 1000.0}),
}
