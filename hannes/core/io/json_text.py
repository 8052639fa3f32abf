"""JSON that anybody may have written: whatever is wrong with it is a ValueError."""

import json
from typing import Any


def parsed(text: str | bytes) -> Any:
    """Return the content of a JSON text; ValueError where it is none, or nested too deep."""
    try:
        return json.loads(text)
    except RecursionError:
        raise ValueError("nested too deep") from None


def table(text: str | bytes) -> dict[str, Any]:
    """Return the content of a JSON object, empty where the text is none."""
    try:
        found = parsed(text)
    except ValueError:
        return {}
    return found if isinstance(found, dict) else {}
