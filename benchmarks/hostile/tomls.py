"""Readers of TOML, of models and of data sets, and the files that they name beside them."""

import shutil
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from benchmarks.hostile import corpus, models, raw_logs, seeds
from benchmarks.hostile.readers import MAPPINGS, Reader
from benchmarks.hostile.toml_seeds import (
    ALONE,
    AXIS,
    BOARD,
    CAMPAIGN,
    EVALUATION,
    EXPERIMENT,
    FINGER,
    HAND,
    OWN,
    SPEC,
)


def furnish(folder: Path) -> None:
    """Files that seeds and mutants name, and Python that nothing may run."""
    (folder / "recording.csv").write_text(corpus.table())
    (folder / "plain.csv").write_text(corpus.table(corpus.COLUMNS, None))
    (folder / "recording.h5").write_bytes(seeds.recording_hdf5())
    (folder / "log.rawlog").write_bytes(raw_logs.of_lines())
    (folder / "grasp.rawlog").write_bytes(raw_logs.grasping())
    (folder / "model.h5").write_bytes(models.model_bytes())
    forces = {**corpus.COLUMNS, "force": 3.0 * corpus.COLUMNS["current"]}
    (folder / "forces.csv").write_text(corpus.table(forces, {**corpus.UNITS, "force": "N"}))
    times = 2e-3 * np.arange(300)
    travel = 0.05 * np.interp(times, corpus.TIME, corpus.ANGLE)
    axis = {"time": times, "reference": travel, "position": travel, "drive": 9.0 * travel}
    units = {"time": "s", "reference": "m", "position": "m", "drive": "V"}
    for name in ("axis", "axis_again"):
        (folder / f"{name}.csv").write_text(corpus.table(axis, units))
    (folder / "finger.csv").write_bytes(seeds.rh56())
    (folder / "own.toml").write_text(OWN)
    (folder / "evaluation.toml").write_text(EVALUATION)
    for name, text in (("hand", HAND), ("experiment", ALONE), ("campaign", CAMPAIGN)):
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


def edited(path: Path) -> None:
    """Go on with logs for which a mapping was begun, and then edited."""
    from hannes.campaigns.begin.begin import MAPPING, begin

    place = path.with_name("mutant_begun")
    place.mkdir()
    try:
        (place / MAPPING).write_bytes(path.read_bytes())
        begin([path.parent / "plain.csv"], place)
    finally:
        shutil.rmtree(place)


def own_python(path: Path) -> None:
    """Find what a file of Python needs, as consent to it does, without running any of it."""
    from hannes.core.trust.consent import digest, named

    toml = path.parent / "own.toml"
    digest(toml, named(toml))


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
    from hannes.recognition.pressed import INPUTS

    found = model_file.read(path)
    found.windows(np.zeros((3, len(NAMES))))
    if found.peak:
        found.peak(np.zeros((1, len(WHOLE))))
    if found.pressed:
        found.pressed(np.zeros((1, INPUTS)))


def data_set(path: Path) -> None:
    """Read what training reads of a data set."""
    from hannes.dataset.read import read
    from hannes.recognition.features import CHANNELS
    from hannes.recognition.train_pressed import inputs_of
    from hannes.recognition.training_set import grasps
    from hannes.recognition.windowing import Windowing

    found = read(path)
    list(found.blocks(np.arange(found.table.size), (*CHANNELS, "force")))
    grasps(found, found.role("train"), Windowing())
    inputs_of(found, Windowing())


def of_settings() -> Iterator[Reader]:
    """Readers of TOML, of models and of data sets."""
    for name, text, use in (
        ("experiment", EXPERIMENT, experiment),
        ("hand", HAND, hand),
        ("hand alone", HAND, hand_alone),
        ("campaign", CAMPAIGN, campaign),
        ("axis campaign", AXIS, campaign),
        ("finger campaign", FINGER, campaign),
        ("mapping", MAPPINGS["text"], mapping),
        ("edited mapping", MAPPINGS["text"], edited),
        ("data set's specification", SPEC, spec),
        ("evaluation", EVALUATION, subjects),
        ("board", BOARD, board),
        ("consent", CAMPAIGN, consent),
    ):
        yield Reader(name, ".toml", text.encode, corpus.toml, use)
    yield Reader("named Python", ".py", seeds.own_effect, corpus.python, own_python)
    yield Reader("model", ".h5", models.model_bytes, corpus.hdf5, model)
    yield Reader("data set", ".h5", models.data_set_bytes, corpus.hdf5, data_set)
