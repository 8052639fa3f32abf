"""The plain position servo as a user would declare it: what follows what, and no limits."""

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from benchmarks.truth import servo
from hannes.core.parameter import Parameter, group
from hannes.core.recording.channel_limits import Expected
from hannes.core.recording.recording import Recording
from hannes.plants.plain import PlainPlant


class Servo(PlainPlant):
    """A position servo, with its drive current logged."""

    name = "servo"
    channels: Mapping[str, str] = {
        "time": "s", "reference": "rad", "position": "rad", "current": "A"
    }  # fmt: skip
    judged = ("position", "current")
    base: ClassVar[tuple[Parameter, ...]] = group(
        "servo", Parameter("inertia", 2e-3, "kg m2", (1e-4, 1e-1), "of the horn and its load")
    )
    block = 0.5

    def simulate(
        self, parameters: Mapping[str, float], recording: Recording
    ) -> dict[str, np.ndarray]:
        """The nominal servo under the recorded command."""
        time = np.arange(recording.time[0], recording.time[-1] + 1e-3, 1e-3)
        asked = np.interp(time, recording.time, recording["reference"])
        run = servo.simulate(servo.SERVO, asked)
        found = {"position": run["position"], "current": run["drive"]}
        return {name: np.interp(recording.time, time, x) for name, x in found.items()}

    expected: ClassVar[Mapping[str, Expected]] = {
        "reference": Expected(peak=(1e-3, 7.0)),
        "position": Expected(follows="reference", peak=(1e-3, 7.0), rate=60.0, lag=0.1),
        "current": Expected(drives="position"),
    }
