"""Rows of a model's evaluation, and the time of one decision."""

import time
from collections.abc import Mapping
from typing import Any

import numpy as np

from benchmarks.harness import Row, interval
from hannes.core.recording.recording import Recording
from hannes.recognition.model import WORDS, Model

SHARES = ("f1_windows", "f1_grasps", "f1_worst", "stable_in_time")
TURNS = 30  # of which the least counts
Evaluation = Mapping[str, Any]


def by_object(name: str, evaluated: Evaluation) -> list[Row]:
    """One row for each object."""
    return [
        {
            "what": f"{name}: {row['name']} ({row['class']})",
            "F1_windows_%": 100 * row["f1_windows"],
            "F1_grasps_%": 100 * row["f1_grasps"],
            "stable_in_150_ms_%": 100 * row["stable_in_time"],
        }
        for row in evaluated["objects"]
    ]


def in_all(name: str, evaluated: Evaluation, ends: Mapping[str, Mapping[str, float]]) -> list[Row]:
    """Averages with intervals, then further results of windows and grasps."""
    begun, trust = evaluated["from_contact"], evaluated["reliability"]
    return [
        {"what": f"{name}: average", **averages({k: 100 * evaluated[k] for k in ends})},
        *({"what": f"{name}: its 95 % interval, {end}",
           **averages({k: ends[k][end] for k in ends})} for end in ("low", "high")),
        {"what": f"{name}: windows from contact on",
         "F1_windows_%": 100 * begun["f1_windows"], "F1_worst_%": 100 * begun["f1_worst"]},
        {"what": f"{name}: since the first newton",
         "stable_in_150_ms_%": 100 * evaluated["stable_in_time_of_a_newton"]},
        *(confused(name, *each) for each in evaluated["confusion"].items()),
        {"what": f"{name}: probabilities", "off_%": 100 * trust["calibration_error"]},
        *({"what": f"{name}: {word} objects decided for good, median",
           "ms": "never" if delay is None else 1e3 * delay}
          for word, delay in evaluated["stable_after_s"].items()),
    ]  # fmt: skip


def confused(name: str, true: str, answers: Mapping[str, int]) -> Row:
    """Of the windows of a class, how many got which answer."""
    whole = max(1, sum(answers.values()))
    shares = {
        f"predicted_{word.replace(' ', '_')}_%": 100 * answers[word] / whole for word in WORDS
    }
    return {"what": f"{name}: {sum(answers.values())} windows of {true} objects", **shares}


def averages(shares: Mapping[str, float]) -> Row:
    """Percent over all objects, as columns."""
    names = ("F1_windows_%", "F1_grasps_%", "F1_worst_%", "stable_in_150_ms_%")
    return dict(zip(names, (shares[name] for name in SHARES), strict=True))


def estimates(what: str, found: Evaluation) -> Row:
    """How far off estimates are, how often intervals hold, and their upper end over their lower."""
    if not found["answered"]:
        return {"what": what, "grasps": found["grasps"], "answered": 0}
    return {"what": what, "grasps": found["grasps"], "answered": found["answered"],
            "off_%": found["median_error_percent"], **errors(found),
            "interval_holds_%": 100 * found["interval_holds"],
            "holds_where_answered_%":
                100 * found["interval_holds"] * found["grasps"] / found["answered"],
            "interval_width": found["interval_width"]}  # fmt: skip


def errors(found: Evaluation) -> dict[str, float]:
    """95 % interval of the median error; it is infinite for a grasp without an estimate."""
    return interval([np.inf if each is None else each for each in found["errors_percent"]])


def held_back(name: str, scores: Evaluation) -> Row:
    """Correct shares of the grasps that a design holds back."""
    right = {"windows_right_%": scores["windows_right"], "grasps_right_%": scores["grasps_right"]}
    return {"what": f"{name}: held back", **{key: 100 * share for key, share in right.items()}}


def decision_time(name: str, model: Model, recording: Recording) -> Row:
    """Processor time of one decision: the features of a window and its class."""
    samples = model.windowing.samples(recording)[np.newaxis]
    windows = model.windowing.ends(samples.shape[1]).size
    model.windows(model.windowing.features(samples)[0])  # compiled now

    def spent() -> float:
        start = time.process_time()
        whole = model.windowing.features(samples)[0]
        for row in whole:
            model.windows(row[np.newaxis])
        return time.process_time() - start

    return {
        "what": f"{name}: one decision",
        "ms": 1e3 * min(spent() for _ in range(TURNS)) / windows,
    }
