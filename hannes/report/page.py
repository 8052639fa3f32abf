"""One page that needs nothing but itself: figures inline, no script, no network."""

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import jinja2
    from markupsafe import Markup

TEMPLATES = Path(__file__).parent / "templates"


def render(template: str, content: Mapping[str, Any]) -> str:
    """Fill `template` with `content`; every value is escaped, an unknown name is an error."""
    return environment().get_template(template).render(**content)


def environment() -> "jinja2.Environment":
    """The templates with what they may call: `inline(svg, alt)`."""
    import jinja2

    made = jinja2.Environment(
        loader=jinja2.FileSystemLoader(TEMPLATES),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    made.globals["inline"] = inline
    return made


def inline(svg: str, alt: str) -> "Markup":
    """Return the SVG for use inside HTML: one labelled image that scales with the page."""
    from markupsafe import Markup, escape

    body = svg[svg.index("<svg") :]
    _, _, body = body.partition(">")
    box = re.search(r'viewBox="[^"]+"', svg)
    assert box is not None
    label = escape(alt)
    return Markup(f'<svg {box.group()} role="img" aria-label="{label}">{body}')


def holding(rows: Sequence[Mapping[str, Any]]) -> int:
    """How many of the rows hold."""
    return sum(bool(row["holds"]) for row in rows)
