"""The public names of the library, with signatures and docstrings."""

import inspect
from typing import Any

import hannes

HEAD = """# Python

All of these come from `hannes` itself.
Units are SI.
"""


def page() -> str:
    """Text of the page, a section a name."""
    return "\n".join([HEAD, *(_name(name) for name in sorted(hannes.__all__, key=str.lower))])


def _name(name: str) -> str:
    found = getattr(hannes, name)
    parts = [f"## {name}\n", f"```text\n{name}{_signature(found)}\n```\n", _doc(found)]
    if inspect.isclass(found):
        parts += [_member(key, each) for key, each in vars(found).items() if _shown(key, each)]
    return "\n".join(part for part in parts if part)


def _shown(key: str, member: Any) -> bool:
    function = getattr(member, "__func__", getattr(member, "fget", member))
    return not key.startswith("_") and inspect.isfunction(function) and bool(function.__doc__)


def _member(key: str, member: Any) -> str:
    function = getattr(member, "__func__", getattr(member, "fget", member))
    shown = key if isinstance(member, property) else f"{key}{_signature(function)}"
    return f"**`{shown}`**\n\n{_doc(function)}"


def _signature(found: Any) -> str:
    if not callable(found):
        return ""
    try:
        parameters = inspect.signature(found).parameters.values()
    except (TypeError, ValueError):
        return ""
    shown, named = [], False
    for each in parameters:
        if each.name in ("self", "cls"):
            continue
        if each.kind is each.KEYWORD_ONLY and not named:
            shown.append("*")
        named = named or each.kind in (each.KEYWORD_ONLY, each.VAR_POSITIONAL)
        shown.append(_parameter(each))
    return f"({', '.join(shown)})"


def _parameter(each: inspect.Parameter) -> str:
    """`name`, or `name=default`; types stand in the docstrings, and differ by Python's version."""
    stars = {each.VAR_POSITIONAL: "*", each.VAR_KEYWORD: "**"}.get(each.kind, "")
    if each.default is each.empty:
        return f"{stars}{each.name}"
    default = repr(each.default)
    return f"{each.name}={default if not default.startswith('<') else '...'}"


def _doc(found: Any) -> str:
    """The docstring; its indented parts as they stand."""
    text = inspect.getdoc(found) or ""
    first, _, rest = text.partition("\n\n")
    shown = f"\n```text\n{rest}\n```\n" if rest else ""
    return f"{' '.join(first.split())}\n{shown}"
