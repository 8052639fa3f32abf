"""What a diagnosis is worth to recognition: training on the base hand and on the one it found.

One hand of the independent truth has a slack leader. It runs the poor protocol, `diagnose` says
what the model is missing, and classifiers are trained on data sets that differ in the hand alone:
the shipped one, and the one that the diagnosis left. All are scored on the same grasps of that
hand. One training set differs from the next by more than its hand, so each is drawn and learnt from
several times.
"""

import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from tqdm import tqdm

from benchmarks.harness import Row
from benchmarks.truth import campaign, objects
from benchmarks.truth.parameters import named
from hannes.campaigns.campaign_file import read_campaign
from hannes.commands.diagnose import diagnose
from hannes.dataset.make import make
from hannes.dataset.spec import find, read_spec
from hannes.recognition.evaluate import CLASSES, Subject, evaluate
from hannes.recognition.train import TREES, train

HIDDEN = {"leader_slack.length": 4e-3}  # m
SEED, GRASPS, TRAININGS, REPEATS = 5, 6, 3, 500
DRAWN = (
    '"leader_slack.length" = { uniform = ["0 mm", "3 mm"] }\n',
    '"gear_load.coefficient" = { uniform = ["0", "0.1"] }\n',
)


def specification(hand: str, share: float, seed: int) -> str:
    """The shipped large data set for another hand, a share as large, no effects drawn."""
    text = find("large").read_text(encoding="utf-8")
    for line in DRAWN:
        text = text.replace(line, "")
    text = text.replace("seed = 1\n", f"seed = {seed}\n")
    text = text.replace('hand = "hannes"', f'hand = "{hand}"')
    text = text.replace('effects = ["leader_slack", "gear_load"]', "effects = []")
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
    """Share of correct windows in each grasp, shape (objects, grasps)."""
    return np.array(
        [
            [
                row["answers"][row["class"]]
                for recording in each.recordings
                for row in evaluate(model, [Subject(each.name, each.label, (recording,))])[
                    "objects"
                ]
            ]
            for each in chosen
        ]
    )


def trained(folder: Path, hand: str, share: float, chosen: Sequence[Subject]) -> np.ndarray:
    """Shares of correct windows after each training, shape (trainings, objects, grasps)."""
    found = []
    for seed in tqdm(range(1, TRAININGS + 1), f"trained on {Path(hand).stem}", leave=False):
        make(read_spec(specification(hand, share, seed)), folder / "set.h5")
        model, _ = train(folder / "set.h5", trees=TREES // 2, seed=seed)
        (folder / "set.h5").unlink()
        found.append(right(model, chosen))
    return np.array(found)


def gained(shares: dict[str, np.ndarray]) -> dict[str, float]:
    """F1 that the diagnosed hand gains [%], with its interval over trainings and grasps."""
    rng, drawn = np.random.default_rng(0), []
    _, things, count = shares["base"].shape
    for _ in range(REPEATS):
        pick, means = rng.integers(0, count, (things, count)), {}
        for kind, each in shares.items():
            some = each[rng.integers(0, len(each), len(each))]
            means[kind] = mean(some[:, np.arange(things)[:, np.newaxis], pick])
        drawn.append(means["diagnosed"] - means["base"])
    low, high = np.percentile(drawn, (2.5, 97.5))
    gain = mean(shares["diagnosed"]) - mean(shares["base"])
    return {"value": gain, "low": float(low), "high": float(high)}


def measure(quick: bool) -> tuple[list[Row], list[Row]]:
    """F1 per window of both, in %, and the difference with its interval."""
    share, count = (0.05, 2) if quick else (0.3, GRASPS)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        made = campaign.make("poor", SEED, HIDDEN)
        made.write(folder)
        verdict = diagnose(read_campaign(folder / "campaign.toml"), out=folder / "found").verdict
        chosen = recorded(named(made.answer["hand"]), count)
        hands = {"base": "hannes", "diagnosed": str(folder / "found" / "hand.toml")}
        shares = {kind: trained(folder, hand, share, chosen) for kind, hand in hands.items()}
    rows = [{"what": f"diagnosed: {verdict.verdict}, {', '.join(verdict.effects) or 'nothing'}"}]
    rows += [
        {
            "what": f"trained on the {kind} hand, {TRAININGS} times",
            "F1_windows_%": mean(each),
            "least_%": min(mean(one[np.newaxis]) for one in each),
        }
        for kind, each in shares.items()
    ]
    return [*rows, {"what": "gained by the diagnosis, points", **gained(shares)}], []


def mean(shares: np.ndarray) -> float:
    """F1 [%] over objects and trainings, from correct shares (trainings, objects, grasps)."""
    return float(np.mean([f1(one.mean(axis=1)) for one in shares]))


def f1(shares: np.ndarray) -> float:
    """Average of the paper's F1 [%] over objects, from correct shares."""
    return float(100.0 * np.mean(2.0 * shares / (shares + 1.0)))
