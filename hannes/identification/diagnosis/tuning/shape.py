"""Constants of the shape: how generic disturbances are fitted where nothing can be named."""

from dataclasses import dataclass

from hannes.identification.tuning_table import COST, DEVELOPMENT, constant


@dataclass(frozen=True)
class ShapeTuning:
    """How what cannot be named is described."""

    most_simulated: float = constant(
        4_000.0, "s", "of single runs for the shape, beside those of the search", COST
    )
    fitted: int = constant(6, "1", "generic disturbances that are fitted, the likeliest", COST)
    steps: int = constant(2, "1", "of each fit before the better half goes on", COST)
    least: float = constant(
        11.0, "chi2", "reduction for which one is drawn, as it is for an unknown", DEVELOPMENT
    )
    least_closed: float = constant(
        0.1, "1", "of the reducible gap on recordings in role show, below which none is drawn"
    )
    explains: float = constant(
        0.9, "1", "of the misfit, for which no gap need fall where none could be seen to fall"
    )
    places: int = constant(41, "1", "of its axis at which it is given", "room on the page")


SHAPE = ShapeTuning()
