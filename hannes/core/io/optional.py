"""Libraries of the optional extras, imported where they are first needed."""

import importlib
from typing import Any

from hannes.core.errors import BadInput


def library(name: str, extra: str) -> Any:
    """Return the module `name`; BadInput where it is not installed, with the extra that has it."""
    try:
        return importlib.import_module(name)
    except ImportError:
        root = name.split(".")[0]
        raise BadInput(
            f"this needs the library {root}, which is not installed: "
            f'pip install "hannes[{extra}]", or pip install {root}'
        ) from None
