"""Free closures of a hand in which something may be hidden: a campaign, and its sealed answer.

python -m benchmarks.truth.closures --out FOLDER --slack "3 mm" --runs 6 --seed 1
"""

import argparse
import json
import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.truth.parameters import nominal, read_hand, to_si
from benchmarks.truth.scatter import run_scatter, scatter
from benchmarks.truth.simulation import EFFECTS, simulate

CHANNELS = ("time_s", "reference_rad", "position_rad", "current_A", "duty_1", "supply_V")
# The stops stand at 19.1 rad of the output shaft, 0.2 rad further for each mm of slack.
TARGET, CLOSING, OPENING = 21.0, 15.4, 25.5  # rad, rad/s, rad/s
HOLD, REST = 0.2, 0.2  # s


def reference(target: float = TARGET) -> list[tuple[float, float]]:
    """Close at full speed, hold, open, rest: points (s, rad at the output shaft)."""
    closed = target / CLOSING
    opened = closed + HOLD + target / OPENING
    return [(0.0, 0.0), (closed, target), (closed + HOLD, target), (opened, 0.0)]


def write(path: Path, text: str) -> None:
    """Writes through a temporary name: a killed run leaves the old file or the new one."""
    path.parent.mkdir(parents=True, exist_ok=True)
    beside = path.with_name(path.name + ".part")
    beside.write_text(text, encoding="utf-8", newline="\n")
    os.replace(beside, path)


def csv_text(channels: dict[str, np.ndarray]) -> str:
    """The recording as CSV, nine digits."""
    rows = zip(*(channels[name].tolist() for name in CHANNELS), strict=True)
    body = (",".join(f"{value:.9g}" for value in row) for row in rows)
    return "\n".join([",".join(CHANNELS), *body]) + "\n"


def campaign_text(files: Sequence[str], base: str | None) -> str:
    """The campaign after the project's contract; nothing in it tells what is hidden."""
    lines = ['plant = "hand"', *([f'base = "{base}"'] if base else []), 'out = "diagnosis"']
    for name in files:
        lines += ["", "[[recording]]", f'file = "{name}"', 'experiment = "void-closure"']
        lines += ['condition = "void, full speed"']
    return "\n".join(lines) + "\n"


def _run(
    hand: dict[str, Any], effects: dict[str, float], rng: np.random.Generator
) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
    values, shift = run_scatter(hand, rng)
    points = reference()
    channels = simulate(
        values, points, duration=points[-1][0] + REST, effects=effects, rng=rng, shift=shift
    )
    changed = {name: value for name, value in values.items() if value != hand[name]}
    return channels, {"late_s": shift, "parameters": changed}


def make(
    out: Path,
    effects: dict[str, float],
    runs: int,
    seed: int,
    base: Path | None = None,
    spread: float = 0.02,
) -> None:
    """Writes recordings, `campaign.toml` and `sealed/answer.json` (opened after the verdict)."""
    nominal_hand = read_hand(base) if base else nominal()
    hand = scatter(nominal_hand, np.random.default_rng([seed, 0]), spread)
    files, told = [], []
    for k in range(1, runs + 1):
        channels, truth = _run(hand, effects, np.random.default_rng([seed, k]))
        files.append(f"void_{k:02d}.csv")
        write(out / files[-1], csv_text(channels))
        told.append({"file": files[-1], **truth})
    if base:
        write(out / "hand.toml", base.read_text(encoding="utf-8"))
    write(out / "campaign.toml", campaign_text(files, "hand.toml" if base else None))
    sealed = {name: {EFFECTS[name][0]: size} for name, size in effects.items()}
    answer = {"effects": sealed, "hand": hand, "runs": told, "seed": seed, "spread": spread}
    write(out / "sealed" / "answer.json", json.dumps(answer, indent=1, sort_keys=True) + "\n")


def _arguments(words: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.truth.closures", description=__doc__
    )
    parser.add_argument("--out", type=Path, required=True, help="folder for the campaign")
    parser.add_argument("--slack", default="none", help='of the leader wire: "3 mm", or none')
    parser.add_argument("--direction", type=float, default=0.0, help="share of the dry friction")
    parser.add_argument("--gear-load", type=float, default=0.0, help="loss by load")
    parser.add_argument("--runs", type=int, default=6)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--spread", type=float, default=0.02, help="of this hand about the nominal")
    parser.add_argument("--hand", type=Path, help="a hand.toml to scatter about")
    return parser.parse_args(words)


def main(words: Sequence[str] | None = None) -> int:
    """Exit status 0, or 2 with one line on standard error."""
    asked = _arguments(words)
    try:
        slack = 0.0 if asked.slack == "none" else to_si(asked.slack, "m")
        sizes = {"leader_slack": slack, "direction_friction": asked.direction}
        sizes["gear_load"] = asked.gear_load
        effects = {name: size for name, size in sizes.items() if size}
        make(asked.out, effects, asked.runs, asked.seed, asked.hand, asked.spread)
    except (ValueError, OSError) as error:
        print(error, file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
