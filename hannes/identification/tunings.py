"""Every tuning constant of the identification methods, as Markdown tables for the documentation.

python -m hannes.identification.tunings
"""

from hannes.identification.calibration.tuning import CALIBRATION
from hannes.identification.diagnosis.tuning import (
    FIT,
    NOISE,
    ONSET,
    PROBABILITY,
    SEARCH,
    SHAPE,
    VERDICT,
)
from hannes.identification.holdout.tuning import HOLDOUT
from hannes.identification.tuning_table import markdown

METHODS = {
    "Diagnosis": (NOISE, FIT, SEARCH, ONSET, VERDICT, PROBABILITY, SHAPE),
    "Hold-out": (HOLDOUT,),
    "Calibration": (CALIBRATION,),
}


def tables() -> str:
    """Return one Markdown section with a table for each method."""
    sections = (f"## {name}\n\n{markdown(*tunings)}" for name, tunings in METHODS.items())
    return "\n".join(sections)


if __name__ == "__main__":
    print(tables(), end="")
