"""The cache folder: machine code and other files that can be made again."""

import atexit
import functools
import os
import shutil
import sys
import tempfile
from pathlib import Path

from hannes.core.errors import BadInput


def cache_home() -> Path:
    """Folder of hannes in the user's cache (HANNES_CACHE or XDG_CACHE_HOME override its parent).

    Where that cannot be written it is a temporary one, which one line on standard error says.
    """
    home = os.environ.get("HANNES_CACHE") or os.environ.get("XDG_CACHE_HOME")
    return _usable(home or "")


@functools.cache
def _usable(home: str) -> Path:
    try:
        folder = (Path(home) if home else Path.home() / ".cache") / "hannes"
        _require_writable(folder)
    except (OSError, RuntimeError, ValueError) as error:
        return _temporary(home, getattr(error, "strerror", None) or str(error))
    return folder


def _require_writable(folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryFile(dir=folder) as probe:
        probe.write(b"0" * 4096)


def _temporary(home: str, why: str) -> Path:
    """A cache that goes when this process ends; those that it starts use it too."""
    try:
        folder = tempfile.mkdtemp(prefix="hannes-cache-")
    except OSError as error:
        raise BadInput(
            f"neither the cache ({why}) nor a temporary folder ({error.strerror}) can be written: "
            "set HANNES_CACHE to a folder that can"
        ) from None
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    os.environ["HANNES_CACHE"] = folder
    place = home or "the home folder"
    print(
        f"hannes: no cache can be kept in {place} ({why}): models are compiled anew each time; "
        "set HANNES_CACHE to a folder that can be written",
        file=sys.stderr,
    )
    made = Path(folder) / "hannes"
    made.mkdir()
    return made
