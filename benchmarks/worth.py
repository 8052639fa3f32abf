"""What a diagnosis is worth to recognition: training on the base hand and on the one it found.

One hand of the independent truth has a slack leader. It runs the poor protocol, `diagnose` says
what the model is missing, and a classifier is trained on each of two data sets that differ in the
hand alone: the shipped one, and the one that the diagnosis left. Both are scored on the same
grasps of that hand.
"""

import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.harness import Row, must_show
from benchmarks.truth import campaign, objects
from benchmarks.truth.parameters import named
from hannes.campaign import read_campaign
from hannes.dataset.make import make
from hannes.dataset.spec import find, read_spec
from hannes.diagnose import diagnose
from hannes.recognition.evaluate import CLASSES, Subject, evaluate
from hannes.recognition.train import train

HIDDEN = {"leader_slack.length": 4e-3}  # m
SEED, GRASPS, REPEATS = 5, 6, 500
SLACK = '"leader_slack.length" = { uniform = ["0 mm", "3 mm"] }\n'


def specification(hand: str, share: float) -> str:
    """The shipped large data set for another hand, a share as large, no slack drawn."""
    text = find("large").read_text(encoding="utf-8").replace(SLACK, "")
    text = text.replace('hand = "hannes"', f'hand = "{hand}"')
    text = text.replace('effects = ["leader_slack"]', "effects = []")
    for draws in (3600, 3400, 3000):
        text = text.replace(f"draws = {draws}", f"draws = {int(draws * share)}")
    return text


def recorded(hand: dict[str, Any], count: int) -> list[Subject]:
    """Grasps of the ten objects by one hand."""
    return [
        Subject(
            each.name,
            CLASSES.index(each.label),
            tuple(objects.grasp(each, (SEED, k, n), hand, HIDDEN) for n in range(count)),
        )
        for k, each in enumerate(objects.things())
    ]


def right(model: Any, chosen: Sequence[Subject]) -> np.ndarray:
    """Share of windows told right in each grasp, shape (objects, grasps)."""
    return np.array(
        [
            [
                row["told"][row["class"]]
                for recording in each.recordings
                for row in evaluate(model, [Subject(each.name, each.label, (recording,))])[
                    "objects"
                ]
            ]
            for each in chosen
        ]
    )


def measure(quick: bool) -> tuple[list[Row], list[Row]]:
    """F1 per window of both, in %, and the difference with its interval."""
    share, count = (0.05, 2) if quick else (0.3, GRASPS)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        made = campaign.make("poor", SEED, HIDDEN)
        made.write(folder)
        verdict = diagnose(read_campaign(folder / "campaign.toml"), out=folder / "found").verdict
        chosen = recorded(named(made.answer["hand"]), count)
        models = {}
        for kind, hand in (("base", "hannes"), ("diagnosed", str(folder / "found" / "hand.toml"))):
            make(read_spec(specification(hand, share)), folder / f"{kind}.h5")
            models[kind] = train(folder / f"{kind}.h5", trees=40)[0]
    shares = {kind: right(model, chosen) for kind, model in models.items()}
    rows = [{"what": f"diagnosed: {verdict.verdict}, {', '.join(verdict.effects) or 'nothing'}"}]
    rows += [
        {"what": f"trained on the {kind} hand", "F1_windows_%": f1(each.mean(axis=1))}
        for kind, each in shares.items()
    ]
    gain = f1(shares["diagnosed"].mean(axis=1)) - f1(shares["base"].mean(axis=1))
    rng, drawn = np.random.default_rng(0), []
    for _ in range(REPEATS):
        pick = rng.integers(0, count, (len(chosen), count))
        some = {kind: np.take_along_axis(each, pick, 1) for kind, each in shares.items()}
        drawn.append(f1(some["diagnosed"].mean(axis=1)) - f1(some["base"].mean(axis=1)))
    low, high = np.percentile(drawn, (2.5, 97.5))
    ends = {"low": float(low), "high": float(high)}
    return rows, [must_show("F1 gained by training on the diagnosed hand", gain, 0, True) | ends]


def f1(shares: np.ndarray) -> float:
    """Average of the paper's F1 [%] over objects, from shares told right."""
    return float(100.0 * np.mean(2.0 * shares / (shares + 1.0)))
