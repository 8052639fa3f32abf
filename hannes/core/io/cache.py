"""The cache folder: machine code and other files that can be made again."""

import os
from pathlib import Path


def cache_home() -> Path:
    """Folder of hannes in the user's cache (HANNES_CACHE or XDG_CACHE_HOME override its parent)."""
    home = os.environ.get("HANNES_CACHE") or os.environ.get("XDG_CACHE_HOME")
    return (Path(home) if home else Path.home() / ".cache") / "hannes"
