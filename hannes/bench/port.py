"""A serial port, a pseudo-terminal or a TCP socket: one class around pyserial, errors in words."""

import errno
import socket
import time
from types import TracebackType
from typing import Any, Self
from urllib.parse import urlsplit

from hannes.core.errors import BadInput

BAUD = 1_000_000
HOST = "127.0.0.1"  # what is served is served to this machine alone
HIGHEST = 65535  # port of TCP


class LinkLost(Exception):
    """The port went away while it was open: a cable that was pulled, a board without power."""


class Port:
    """An open port; reads what is there, writes all that is given.

    `name`: a device, or a URL that pyserial knows (`socket://127.0.0.1:4000`). Raises BadInput in
    one line where it cannot be opened. `notes` says what could be had of low latency.
    """

    def __init__(self, name: str, baud: int = BAUD) -> None:
        import serial

        self.name, self.baud = name, baud
        _require_number(name)
        try:
            self._port: Any = serial.serial_for_url(
                name, baudrate=baud, timeout=0.02, write_timeout=1.0, exclusive=True
            )
        except (OSError, ValueError) as error:  # SerialException is an OSError
            raise BadInput(_why(name, error)) from None
        self._port.reset_input_buffer()  # what was sent before anybody listened is no frame
        self.notes = self._low_latency()

    def read(self) -> bytes:
        """Return what has come, waiting up to 20 ms for a first byte; LinkLost where it is gone."""
        try:
            data: bytes = self._port.read(1)
            if data and (more := self._port.in_waiting):
                data += self._port.read(more)
            return data
        except (OSError, TypeError) as error:
            raise LinkLost(f"{self.name}: the link was lost ({error})") from None

    def write(self, data: bytes) -> None:
        """Write all of `data`; LinkLost where the port is gone or takes nothing for a second."""
        try:
            self._port.write(data)
        except (OSError, TypeError) as error:
            raise LinkLost(f"{self.name}: the link was lost ({error})") from None

    def close(self) -> None:
        """Close the port; harmless where it is gone."""
        try:
            self._port.close()
        except OSError:
            pass

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.close()

    def _low_latency(self) -> str:
        """Ask the driver to hand over bytes at once; says whether it does."""
        ask = getattr(self._port, "set_low_latency_mode", None)
        if ask is None:
            return "low latency: this kind of port has no such mode"
        try:
            ask(True)
        except (OSError, ValueError):
            return "low latency: refused by the driver"
        return "low latency: on"


def _require_number(name: str) -> None:
    """Raise BadInput for a URL without a port number: pyserial's words for it are of its inside."""
    if not name.lower().startswith(("socket://", "rfc2217://")):
        return
    try:
        number = urlsplit(name).port
    except ValueError:
        number = None
    if number is None:
        kind = name.partition(":")[0]
        raise BadInput(f"{name}: expected {kind}://HOST:PORT, with a port from 0 to {HIGHEST}")


def _why(name: str, error: Exception) -> str:
    """One line: absent, forbidden, busy or something else, and what to do."""
    number, text = getattr(error, "errno", None), str(error)
    if number == errno.ENOENT or "No such file" in text or "could not find" in text:
        return (
            f"{name}: there is no such port; is the cable in? `hannes port` lists those there are"
        )
    if number == errno.EACCES or "Permission denied" in text:
        return f"{name}: you may not open it; add yourself to the group of the device (dialout)"
    if number in (errno.EBUSY, errno.EAGAIN) or "lock" in text or "busy" in text.lower():
        return f"{name}: it is busy; another program has it open: close that first"
    if number == errno.ECONNREFUSED or "refused" in text:
        return f"{name}: nothing listens there; start the board first"
    if number in (errno.ENOTTY, errno.EISDIR) or "Inappropriate ioctl" in text:
        return f"{name}: it is no serial port; `hannes port` lists those there are"
    if "invalid URL" in text:
        return f"{name}: this kind of port is not known; expected a device, or socket://HOST:PORT"
    return f"{name}: it cannot be opened ({text.rpartition(f'{name}: ')[2]})"


def listening(number: int) -> socket.socket:
    """A socket that listens on a TCP port of this machine alone; 0: any that is free.

    Raises BadInput where the port cannot be had.
    """
    try:
        if not 0 <= number <= HIGHEST:
            raise OSError(f"expected 0 to {HIGHEST}")
        return socket.create_server((HOST, number))
    except OSError as error:
        why = error.strerror or str(error)
        raise BadInput(f"cannot serve on {HOST}, port {number}: {why}") from None


def listed() -> list[tuple[str, str]]:
    """Serial ports of this machine, and what they call themselves."""
    from serial.tools import list_ports

    return [(each.device, each.description) for each in list_ports.comports()]


def now() -> int:
    """Host time [ns] of a monotonic clock, the same in all processes of this machine."""
    return time.monotonic_ns()
