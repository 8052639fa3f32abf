"""A Vernier Go Direct hand dynamometer read while the board is recorded.

The library `godirect` is Vernier's, and under the GPL (version 3): it is an extra of its own, which
is imported here alone, and only where a live dynamometer is asked for.
"""

import contextlib
import threading
import time
from typing import Any, Self

import numpy as np

from hannes.bench.dynamometer import ForceLog
from hannes.core.errors import BadInput

PERIOD = 10  # ms between samples
WAIT = 500  # ms for one


class LiveDynamometer:
    """Reads force from the device on USB, with the host's time, until it is closed.

    Raises BadInput where the library or the device is missing.
    """

    def __init__(self) -> None:
        try:
            from godirect import GoDirect
        except ImportError:
            raise BadInput(
                "a live dynamometer needs Vernier's library, which is under the GPL: "
                "pip install 'hannes[dynamometer]', or merge its CSV export"
            ) from None
        self._library: Any = GoDirect(use_ble=False, use_usb=True)
        self._device: Any = self._library.get_device()
        if self._device is None or not self._device.open(auto_start=False):
            self._library.quit()
            raise BadInput("no Vernier device on USB: is it plugged in and switched on?")
        self._device.enable_default_sensors()
        self._device.start(period=PERIOD)
        self._rows: list[tuple[float, float]] = []
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._read, daemon=True)
        self._thread.start()

    def _read(self) -> None:
        while not self._over.is_set():
            if self._device.read(timeout=WAIT):
                (sensor, *_) = self._device.get_enabled_sensors()
                self._rows += [(time.monotonic(), float(value)) for value in sensor.values]
                sensor.clear()

    def log(self) -> ForceLog:
        """What was read so far. Samples that came together are spread over their periods."""
        if not self._rows:
            raise BadInput("no sample came from the dynamometer")
        stamps, force = np.array(self._rows).T
        steps = PERIOD * 1e-3 * np.arange(stamps.size)
        return ForceLog(float(np.min(stamps - steps)) + steps, force)

    def close(self) -> None:
        """Stop the device."""
        self._over.set()
        self._thread.join(2.0 * WAIT * 1e-3)
        with contextlib.suppress(OSError):
            self._device.stop()
            self._device.close()
        self._library.quit()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
