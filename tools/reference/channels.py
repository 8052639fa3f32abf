"""Channels of recordings: of the hand with meanings, of the other plants that ship."""

from hannes.plants.protocol import PLANTS, Plant, expectations, find_plant
from tools.reference.markdown import code, number, table

# Of the hand; what is recorded and what is simulated have one name.
MEANINGS = {
    "time": "sampling instants, rising; required",
    "reference": "commanded position at the output shaft (behind the 19:1 reducer), "
    "rising while it closes",
    "position": "encoder, as at the output shaft",
    "current": "motor current, positive where it closes the hand",
    "duty": "of the PWM drive, -1 to 1, positive where it closes the hand",
    "supply": "bus voltage",
    "force": "sum of the phalanges' normal forces on the object: instrumented objects, simulations",
    "sensor": "of a dynamometer, along its sensing axis",
}
HEAD = """# Channels

A recording is one run.
As CSV (`.csv`, `.csv.gz`) it has one column a channel, named `name_unit`, such as `current_A`.
As HDF5 (`.h5`) it has a dataset a channel in the group `/channels`, each with an attribute `unit`.
`Recording.read("a.h5").to_csv("a.csv")` turns one into the other.

All values are SI.
At least one compared channel is needed.
A recorded reference drives the simulation.
Without one the experiment's own reference does, and then the clocks must agree.
"""


def page() -> str:
    """Text of the page."""
    return "\n".join([HEAD, *(_plant(name) for name in PLANTS)])


def _plant(name: str) -> str:
    plant = find_plant(name)
    columns = ["column", "used", "plausible peak", "is"]
    rows = [_row(plant, channel, unit) for channel, unit in plant.channels.items()]
    if name != "hand":
        columns, rows = columns[:3], [row[:3] for row in rows]
    return f'## Plant "{name}"\n\n{table(columns, rows)}\n'


def _row(plant: Plant, channel: str, unit: str) -> list[str]:
    return [
        code(f"{channel}_{unit}"),
        _use(plant, channel),
        _peak(plant, channel, unit),
        MEANINGS.get(channel, ""),
    ]


def _use(plant: Plant, channel: str) -> str:
    if channel == "time" or channel in plant.required:
        return "required"
    return "compared" if channel in plant.judged else "drives the simulation"


def _peak(plant: Plant, channel: str, unit: str) -> str:
    """What `hannes check` takes for plausible."""
    found = expectations(plant).get(channel)
    if found is None or found.peak[1] == float("inf"):
        return ""
    low, high = (number(each) for each in found.peak)
    return f"{low} to {high}" + (f" {unit}" if unit != "1" else "")
