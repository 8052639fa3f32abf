"""Provenance of results: versions, machine, date."""

import datetime
import platform
from importlib.metadata import PackageNotFoundError, version

from hannes.core.version import VERSION

LIBRARIES = ("numpy", "scipy", "numba", "h5py", "matplotlib")


def versions() -> dict[str, str]:
    """Versions of hannes, Python and the libraries that numbers and figures come from."""
    known = {"hannes": VERSION, "python": platform.python_version()}
    return known | {name: _installed(name) for name in LIBRARIES}


def provenance() -> dict[str, object]:
    """Versions, machine and date: for summaries, not for recordings and pages."""
    return {
        "versions": versions(),
        "machine": platform.machine(),
        "date": datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"),
    }


def _installed(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "not installed"
