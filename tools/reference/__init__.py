"""Pages of docs/reference that the code itself knows: `python -m tools.reference` writes them."""

from pathlib import Path

from tools.reference import (
    channels,
    commands,
    effects,
    kernel_variables,
    limits,
    parameters,
    python,
    tuning,
    verdicts,
)

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "docs" / "reference"
NOTICE = (
    "<!-- Written by `python -m tools.reference` from the code: edit that, not this page. -->\n"
)
PAGES = {
    "channels.md": channels.page,
    "commands.md": commands.page,
    "effects.md": effects.page,
    "kernel-variables.md": kernel_variables.page,
    "limits.md": limits.page,
    "parameters.md": parameters.page,
    "python.md": python.page,
    "tuning-constants.md": tuning.page,
    "verdicts.md": verdicts.page,
}


def written(name: str) -> str:
    """Text of a generated page as the code is now."""
    return f"{NOTICE}\n{PAGES[name]().rstrip()}\n"
