"""Boards that are known by name: each adapter is one small class."""

import importlib
from typing import Any

from hannes.bench.events import Adapter
from hannes.core.errors import BadInput, nearest

ADAPTERS = {
    "hannes": "hannes.bench.adapters.framed:Framed",
    "text": "hannes.bench.adapters.text_lines:TextLines",
    "feetech": "hannes.bench.adapters.feetech:Feetech",
}


def adapter(name: str, **options: Any) -> Adapter:
    """Return a new adapter by its name; BadInput where there is none of that name."""
    if name not in ADAPTERS:
        known = ", ".join(ADAPTERS)
        raise BadInput(f'no board adapter "{name}"{nearest(name, ADAPTERS)} (known: {known})')
    module, _, attribute = ADAPTERS[name].partition(":")
    found: Adapter = getattr(importlib.import_module(module), attribute)(**options)
    return found
