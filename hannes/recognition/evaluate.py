"""`hannes evaluate`: a model on recordings of known objects, scored as the paper's Table III is.

The paper's formula (its names of precision and recall are swapped): PR = nP / (nP + nFN),
RE = nP / (nP + nFP), F1 = 2 PR RE / (PR + RE). It leaves open what is counted. Here windows are
counted, those between contact and release (5 % of the peak force) of all grasps of an object. They
are positive where they are of the object's class. Features look back over two lengths of a window,
so the first scored window ends that long after contact; `from_contact` scores those before it too.
An object has one class, so nFP = 0 and RE = 1. With R the share of windows classified right,
F1 = 2 R / (R + 1). "Don't know" is wrong. Windows are classified one by one. The class of a grasp,
and the time of it, come from the running decision, which does not know the time of contact.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from hannes.core.errors import BadInput
from hannes.core.io.file_patterns import matching
from hannes.core.io.toml_table import Table, read_text
from hannes.core.recording.recording import Recording
from hannes.dataset.shard import touching
from hannes.recognition.interval_scores import judged
from hannes.recognition.model import RIGID, UNKNOWN, WORDS, Model, decided, plain
from hannes.recognition.training_set import scored
from hannes.recognition.windowing import Windowing

CLASSES = WORDS[:2]
STABLE = 0.15  # s from contact
LEAST, MOST = 1.0, 1e9  # N/m, of an object


@dataclass(frozen=True)
class Subject:
    """An object with its class (SOFT or RIGID), recordings of grasps, stiffness [N/m] if known."""

    name: str
    label: int
    recordings: tuple[Recording, ...]
    stiffness: float | None = None


def f1(right: float) -> float:
    """The paper's F1 of an object of one class, from the share `right` classified right."""
    return 2.0 * right / (right + 1.0)


def read_subjects(path: str | Path) -> tuple[str, list[Subject]]:
    """Title and objects of an evaluation.toml; files are relative to it, globs allowed."""
    root = Table.parse(read_text(Path(path)), str(path), ("title", "object"))
    if not root.require("object", '[{ name = "Ball", class = "soft", file = "ball-*.h5" }]'):
        root.refuse("object", "is empty: expected one object or more")
    made = [_subject(root, k) for k in range(len(root.items("object")))]
    return root.text("title", Path(path).stem), made


def _subject(root: Table, k: int) -> Subject:
    given = root.items("object")[k]
    if not isinstance(given, dict):
        root.refuse("object", "must be tables: lines [[object]], keys below each")
    table = Table(given, root.where, ("name", "class", "file", "stiffness"), f"object[{k}].")
    table.require("file", '"ball-*.h5"')
    pattern = table.text("file", "")
    try:
        files = matching(pattern, Path(root.where).parent) if pattern else []
    except BadInput as error:
        table.refuse("file", f"cannot be used: {error}")
    if not files:
        table.refuse("file", f'= "{pattern}": no such file')
    recordings = tuple(Recording.read(each) for each in files)
    for each, recording in zip(files, recordings, strict=True):
        _require_force(each, recording)
    name = table.text("name", f"object {k + 1}")
    stiffness = table.quantity("stiffness", "N/m") if "stiffness" in table else None
    if stiffness is not None and not LEAST <= stiffness <= MOST:
        table.refuse("stiffness", f"= {stiffness:g} N/m: expected from {LEAST:g} to {MOST:g} N/m")
    return Subject(name, CLASSES.index(table.choice("class", CLASSES)), recordings, stiffness)


def _require_force(path: Path, recording: Recording) -> None:
    if "force" not in recording:
        raise BadInput(
            f"{path}: has no force; contact and release are read from it (training needs none)"
        )
    try:
        recording.expect({**recording.units, "force": "N"}, ("force",))
    except BadInput as error:
        raise BadInput(f"{path}: {error}") from None


def evaluate(model: Model, subjects: Sequence[Subject]) -> dict[str, Any]:
    """Rows by object, averages, confusion, reliability; BadInput where nothing was touched."""
    grasps = [(each, _grasp(model, each, rec)) for each in subjects for rec in each.recordings]
    rows = [_row(each, [found for own, found in grasps if own is each]) for each in subjects]
    every = [found for _, found in grasps]
    return {
        "objects": rows,
        "f1_windows": float(np.mean([row["f1_windows"] for row in rows])),
        "f1_grasps": float(np.mean([row["f1_grasps"] for row in rows])),
        "f1_worst": min(row["f1_windows"] for row in rows),
        "from_contact": {
            "f1_windows": float(np.mean([row["f1_from_contact"] for row in rows])),
            "f1_worst": min(row["f1_from_contact"] for row in rows),
        },
        "stable_after_s": {
            word: _after([found["delay"] for own, found in grasps if own.label == label])
            for label, word in enumerate(CLASSES)
        },
        "stable_in_time": float(np.mean([found["delay"] <= STABLE for found in every])),
        "stable_in_time_of_a_newton": float(np.mean([x["since_newton"] <= STABLE for x in every])),
        "stable_s": STABLE,
        "confusion": _confusion(grasps),
        "reliability": _reliability(grasps),
        "force": judged([(found["force"], found["peak"]) for found in every]),
        "stiffness": judged(
            [(own.stiffness, found["stiffness"]) for own, found in grasps if own.stiffness]
        ),
    }


def learning_curve(
    models: Iterable[tuple[int, Model]], subjects: Sequence[Subject]
) -> list[dict[str, Any]]:
    """Scores of models, each with the number of grasps that it was trained on."""
    keys = ("f1_windows", "f1_grasps", "f1_worst", "stable_in_time")
    rows = []
    for count, model in models:
        predicted = evaluate(model, subjects)
        rows.append({"grasps": count, **{key: predicted[key] for key in keys}})
    return rows


def _grasp(model: Model, subject: Subject, recording: Recording) -> dict[str, Any]:
    """One grasp: class of each scored window, delay of the decision, the peak force."""
    predicted, force = model.predict(recording), recording["force"]
    inside = grasp_scope(subject, recording, model.windowing, predicted.time)
    contact, release = touching(recording.time, force)
    during = (predicted.time >= contact) & (predicted.time <= release)
    right = decided(predicted.running, model.sure) == subject.label
    first, _ = touching(recording.time, force, share=0.0)
    right &= predicted.decision != WORDS[UNKNOWN]  # without a detected contact it is a guess
    return {
        "windows": decided(predicted.rigid, model.sure)[inside],
        "from_contact": decided(predicted.rigid, model.sure)[during],
        "rigid": predicted.rigid[inside],
        "grasp": WORDS.index(predicted.decision),
        "delay": delay(predicted.time, right, contact, release),
        "since_newton": delay(predicted.time, right, first, release),
        "force": float(force.max()),
        "peak": predicted.peak_force,
        "stiffness": predicted.stiffness,
    }


def grasp_scope(
    subject: Subject, recording: Recording, windowing: Windowing, times: np.ndarray
) -> np.ndarray:
    """Which windows (their `times` [s]) count; BadInput where none lies within the contact."""
    contact, release = touching(recording.time, recording["force"])
    if np.isnan(contact):
        raise BadInput(f"{subject.name}: a recording in which nothing is touched")
    inside = scored(times, windowing, np.array([contact]), np.array([release]))[0]
    if not inside.any():
        raise BadInput(f"{subject.name}: an object was held for less than one window")
    return inside


def delay(times: np.ndarray, right: np.ndarray, contact: float, release: float) -> float:
    """Time from contact from which decisions are right until release [s]; infinite if never."""
    during = (times >= contact) & (times <= release)
    since, fine = times[during] - contact, right[during]
    if not fine.size or not fine[-1]:
        return float("inf")
    wrong = np.flatnonzero(~fine)
    return float(since[0] if not wrong.size else since[wrong[-1] + 1])


def _row(subject: Subject, grasps: list[dict[str, Any]]) -> dict[str, Any]:
    windows = np.concatenate([each["windows"] for each in grasps])
    whole = np.array([each["grasp"] for each in grasps])
    shares = {word: float(np.mean(windows == k)) for k, word in enumerate(WORDS)}
    stiffness = [each["stiffness"].value for each in grasps if each["stiffness"]]
    begun = np.concatenate([each["from_contact"] for each in grasps])
    delays = np.array([each["delay"] for each in grasps])
    return {
        "name": subject.name,
        "class": CLASSES[subject.label],
        "grasps": len(grasps),
        "windows": int(windows.size),
        "answers": shares,
        "f1_windows": f1(float(np.mean(windows == subject.label))),
        "f1_from_contact": f1(float(np.mean(begun == subject.label))),
        "f1_grasps": f1(float(np.mean(whole == subject.label))),
        "stable_after_s": _after(delays.tolist()),
        "stable_in_time": float(np.mean(delays <= STABLE)),
        "stiffness_N_per_m": float(np.median(stiffness)) if stiffness else None,
    }


def _after(delays: Sequence[float]) -> float | None:
    """Median time to a stable decision [s]; None where half have none."""
    middle = float(np.median(delays)) if len(delays) else np.inf
    return middle if np.isfinite(middle) else None


def _confusion(grasps: Sequence[tuple[Subject, dict[str, Any]]]) -> dict[str, dict[str, int]]:
    """Windows by class, then by predicted class."""
    found = {}
    for label, word in enumerate(CLASSES):
        mine = [predicted["windows"] for subject, predicted in grasps if subject.label == label]
        windows = np.concatenate(mine) if mine else np.array([], int)
        found[word] = {predicted: int((windows == k).sum()) for k, predicted in enumerate(WORDS)}
    return found


def _reliability(grasps: Sequence[tuple[Subject, dict[str, Any]]]) -> dict[str, Any]:
    """Predicted probability of rigid against its frequency, in tenths; calibration error."""
    predicted = np.concatenate([each["rigid"] for _, each in grasps])
    true = np.concatenate(
        [np.full(each["rigid"].size, s.label == RIGID, float) for s, each in grasps]
    )
    tenth = np.minimum((10.0 * predicted).astype(int), 9)
    rows = [
        {
            "predicted": float(predicted[tenth == k].mean()),
            "rigid": float(true[tenth == k].mean()),
            "windows": int((tenth == k).sum()),
        }
        for k in np.unique(tenth)
    ]
    error = (
        sum(row["windows"] * abs(row["predicted"] - row["rigid"]) for row in rows) / predicted.size
    )
    brier = float(np.mean((predicted - true) ** 2))
    return {"rows": rows, "calibration_error": float(error), "brier": brier}


def prediction_of(model: Model, recording: Recording) -> dict[str, Any]:
    """A model's prediction for one recording, as plain data for JSON."""
    predicted = model.predict(recording)
    return {
        "decision": predicted.decision,
        "rigid": predicted.probability,
        "stiffness": plain(predicted.stiffness, "N/m"),
        "peak_force": plain(predicted.peak_force, "N"),
    }
