"""The smallest size of each hidden effect that any analyst could hope to detect.

An oracle knows what the analyst does not: which effect is hidden, with which sign, how it shows,
and how hands and runs scatter. Whatever it cannot see at 80 % power and 5 % false alarm, nobody
needs to name.
"""

from pathlib import Path

FROZEN = Path(__file__).parent / "smallest_detectable.toml"  # of a release: what the study hides
APART = Path(__file__).parent / "fingers_apart.toml"  # where each joint is off for itself
FOLDER = Path(__file__).parent / "sizes"  # NAME.toml: an effect that came after that
