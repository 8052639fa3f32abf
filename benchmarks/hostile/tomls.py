"""Readers of TOML, of models and of data sets, and the files that they name beside them."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.hostile import corpus, models
from benchmarks.hostile.readers import MAPPINGS, Reader, recording_hdf5

EXPERIMENT = """
title = "a ball"
hand = "hannes"
duration = "0.6 s"
sampling = "1 kHz"
controller = "continuous"
effects = ["supply_sag"]
[reference]
kind = "ramp"
points = [["0 s", "0 rad"], ["0.4 s", "5 rad"], ["0.6 s", "0 rad"]]
[object]
shape = "sphere"
radius = "36 mm"
position = ["4 mm", "-47 mm", "0 mm"]
material = { stiffness = "800 N/m", damping = "20 N s/m", friction = "0.4" }
sensor = true
[noise]
current = "10 mA"
seed = 1
[parameters]
"motor.dry_friction" = "0.0055 N m"
[sweep]
"object.radius" = ["36 mm", "35 mm"]
"""
HAND = """
base = "hannes"
effects = ["supply_sag", "capstan"]
[parameters]
"motor.dry_friction" = "0.0055 N m"
"supply_sag.resistance" = "0.2 ohm"
"""
CAMPAIGN = """
title = "two runs"
plant = "hand"
base = "hand.toml"
out = "results"
effects = ["gear_load"]
[[recording]]
file = "recording.csv"
condition = "closure"
experiment = "experiment.toml"
role = "fit"
[[recording]]
file = "recording.h5"
runs = "0:1"
[calibrate]
parameters = ["motor.dry_friction"]
starts = 2
[diagnose]
run_scatter = "0.01"
"""
AXIS = """
title = "two runs of an axis"
plant = "axis"
out = "results"
[[recording]]
file = "axis.csv"
condition = "back and forth"
[[recording]]
file = "axis_again.csv"
condition = "back and forth"
[calibrate]
starts = 2
"""
SPEC = """
title = "some"
seed = 1
duration = "0.3 s"
sampling = "1 kHz"
border = "5 kN/m"
channels = ["current", "force"]
[reference]
kind = "ramp"
points = [["0 s", "0 rad"], ["0.3 s", "5 rad"]]
[values]
"motor.dry_friction" = { spread = "0.05" }
"noise.current" = "10 mA"
[[grasps]]
name = "balls"
shape = "sphere"
role = "train"
draws = 3
[grasps.values]
"object.stiffness" = ["800 N/m", "2000 N/m"]
"""
EVALUATION = """
title = "known"
[[object]]
name = "Ball"
class = "soft"
file = "forces.csv"
stiffness = "800 N/m"
"""
BOARD = """
experiment = "experiment.toml"
variant = 1
seed = 1
[board]
watchdog = "200 ms"
current_limit = "6 A"
[misbehaviour]
lost = "0.1 %"
late = "5 ms"
cut = "3 s"
drift = "0.004 %"
garbled = false
"""


def furnish(folder: Path) -> None:
    """Files that seeds and mutants name, and Python that nothing may run."""
    (folder / "recording.csv").write_text(corpus.table())
    (folder / "plain.csv").write_text(corpus.table(corpus.COLUMNS, None))
    (folder / "recording.h5").write_bytes(recording_hdf5())
    forces = {**corpus.COLUMNS, "force": 3.0 * corpus.COLUMNS["current"]}
    (folder / "forces.csv").write_text(corpus.table(forces, {**corpus.UNITS, "force": "N"}))
    times = 2e-3 * np.arange(300)
    travel = 0.05 * np.interp(times, corpus.TIME, corpus.ANGLE)
    axis = {"time": times, "reference": travel, "position": travel, "drive": 9.0 * travel}
    units = {"time": "s", "reference": "m", "position": "m", "drive": "V"}
    for name in ("axis", "axis_again"):
        (folder / f"{name}.csv").write_text(corpus.table(axis, units))
    (folder / "evaluation.toml").write_text(EVALUATION)
    alone = EXPERIMENT.partition("[sweep]")[0]
    for name, text in (("hand", HAND), ("experiment", alone), ("campaign", CAMPAIGN)):
        (folder / f"{name}.toml").write_text(text)
    for name, text in MAPPINGS.items():
        (folder / f"{name}.mapping.toml").write_text(text)
    (folder / "folder").mkdir()


def hand(path: Path) -> None:
    """Read a hand and describe it, as a look does."""
    from hannes.plants.plant_file import load_model, own_python_described

    own_python_described(str(path))
    load_model(str(path))


def hand_alone(path: Path) -> None:
    """Read a hand."""
    from hannes.simulation.hand.hand_file import load_hand

    load_hand(path)


def experiment(path: Path) -> None:
    """Read an experiment, and as the text that a recording carries."""
    from hannes import load_experiment
    from hannes.core.errors import BadInput
    from hannes.core.io.toml_table import read_text
    from hannes.simulation.experiment.reader import parse_experiment

    try:
        parse_experiment(read_text(path))
    except BadInput:
        pass
    load_experiment(path)


def campaign(path: Path) -> None:
    """Read a campaign and what it says of calibration and diagnosis."""
    from hannes.campaigns.campaign_file import read_campaign
    from hannes.identification.calibration.settings import read_plan
    from hannes.identification.diagnosis.settings import read_settings

    found = read_campaign(path)
    channels = {name for each in found.entries for name in each.recording.names}
    read_plan(found.calibrate, found.plant, channels)
    read_settings(found.diagnose, found.plant)


def mapping(path: Path) -> None:
    """Read a mapping, and a file through it."""
    from hannes import convert
    from hannes.campaigns.foreign.mapping_file import read_mapping

    convert([path.parent / "plain.csv"], read_mapping(path))


def spec(path: Path) -> None:
    """Read a data set's specification."""
    from hannes.dataset.spec import load_spec

    load_spec(path)


def subjects(path: Path) -> None:
    """Read what a model is evaluated on."""
    from hannes.recognition.evaluate import read_subjects

    read_subjects(path)


def board(path: Path) -> None:
    """Read a virtual board."""
    from hannes.bench.board_file import read_board

    read_board(path)


def consent(path: Path) -> None:
    """Find the Python that a file and those that it leads to name."""
    from hannes.core.trust.consent import digest, named, reached

    for each in reached(path):
        digest(each, named(each))


def model(path: Path) -> None:
    """Read a model and ask it."""
    from hannes.recognition import model_file
    from hannes.recognition.features import NAMES
    from hannes.recognition.hysteresis_features import WHOLE

    found = model_file.read(path)
    found.windows(np.zeros((3, len(NAMES))))
    if found.peak:
        found.peak(np.zeros((1, len(WHOLE))))


def data_set(path: Path) -> None:
    """Read what training reads of a data set."""
    from hannes.dataset.read import read
    from hannes.recognition.features import CHANNELS

    found = read(path)
    list(found.blocks(np.arange(found.table.size), (*CHANNELS, "force")))


def of_settings() -> Iterator[Reader]:
    """Readers of TOML."""
    simulation, core = "hannes.simulation.", "hannes.core.io.toml_table:read_text"
    reader = f"{simulation}experiment.reader:"
    parts = tuple(reader + each for each in ("read_experiment", "read_reference", "read_object"))
    loads = tuple(
        f"{simulation}experiment.load:{each}" for each in ("load", "load_experiment", "read")
    )
    files = f"{simulation}hand.hand_file:"
    found: tuple[tuple[str, str, Callable[[Path], Any], tuple[str, ...]], ...] = (
        ("experiment", EXPERIMENT, experiment, (*parts, *loads, core)),
        ("hand", HAND, hand, ("hannes.plants.plant_file:load_model", f"{files}load")),
        ("hand alone", HAND, hand_alone, (f"{files}load_hand",)),
        ("campaign", CAMPAIGN, campaign, (
            "hannes.campaigns.campaign_file:read_campaign",
            "hannes.campaigns.campaign_file:read_runs",
            "hannes.identification.calibration.settings:read_plan",
            "hannes.identification.diagnosis.settings:read_settings",
        )),
        ("axis campaign", AXIS, campaign, ()),
        ("mapping", MAPPINGS["text"], mapping,
         ("hannes.campaigns.foreign.mapping_file:read_mapping",)),
        ("data set's specification", SPEC, spec, (
            "hannes.dataset.spec:load_spec", "hannes.dataset.spec:read_spec",
            "hannes.dataset.distributions:read_distribution",
        )),
        ("evaluation", EVALUATION, subjects, ("hannes.recognition.evaluate:read_subjects",)),
        ("board", BOARD, board, ("hannes.bench.board_file:read_board",)),
        ("consent", CAMPAIGN, consent, ()),
    )  # fmt: skip
    for name, text, use, covers in found:
        yield Reader(name, ".toml", text.encode, corpus.toml, use, covers)
    yield Reader(
        "model",
        ".h5",
        models.model_bytes,
        corpus.hdf5,
        model,
        ("hannes.recognition.model_file:read",),
    )
    yield Reader(
        "data set",
        ".h5",
        models.data_set_bytes,
        corpus.hdf5,
        data_set,
        ("hannes.dataset.read:read",),
    )
