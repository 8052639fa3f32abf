"""A figure as the page needs it: its SVG, its caption, and words for those who cannot see it."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from hannes.report import style

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Drawn:
    """`name` is the file's stem; `alt` says what is to be seen; `svg` stands alone."""

    name: str
    title: str
    caption: str
    alt: str
    svg: str


def drawn(name: str, title: str, caption: str, alt: str, draw: Callable[[], "Figure"]) -> Drawn:
    """Draw in the project's style and return the result."""
    with style.styled():
        return Drawn(name, title, caption, alt, style.svg(draw(), name))
