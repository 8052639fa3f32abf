"""Take one figure out of a diagnosis' page: `python -m tools.diagnosis_picture PAGE.html OUT.svg`.

Coordinates are rounded to a tenth of a pixel, which halves the file.
"""

import argparse
import re
from pathlib import Path

FIGURE = "diagnosis-position"


def picture(page: str, figure: str = FIGURE) -> str:
    """The SVG of a figure as a file of its own."""
    found = re.search(rf'<figure id="{figure}">\s*<svg ([^>]*)>(.*?)</svg>', page, re.DOTALL)
    if found is None:
        raise SystemExit(f"no figure {figure} on this page: expected report.html of a diagnosis")
    box = re.search(r'viewBox="0 0 ([\d.]+) ([\d.]+)"', found[1])
    assert box is not None
    width, height = (float(each) * 1.6 for each in box.groups())
    spaces = 'xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink"'
    drawn = _rounded(found[2]).strip()
    return f'<svg {spaces} width="{width:.0f}" height="{height:.0f}" {found[1]}>\n{drawn}\n</svg>\n'


def _rounded(text: str) -> str:
    """Numbers of paths with one decimal, a path on one line; words as they are."""

    def path(found: re.Match[str]) -> str:
        near = re.sub(r"-?\d+\.\d+", lambda each: f"{float(each[0]):.1f}", found[2])
        return f"{found[1]}{' '.join(near.split())}{found[3]}"

    return re.sub(r'( d=")([^"]*)(")', path, text)


def main() -> None:
    """Read the page, write the picture."""
    parser = argparse.ArgumentParser(prog="python -m tools.diagnosis_picture", description=__doc__)
    parser.add_argument("page", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("--figure", default=FIGURE, help=f"its name on the page ({FIGURE})")
    asked = parser.parse_args()
    text = picture(asked.page.read_text(encoding="utf-8"), asked.figure)
    asked.out.write_text(text, encoding="utf-8", newline="\n")


if __name__ == "__main__":
    main()
