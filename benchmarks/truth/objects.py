"""Recordings of the ten objects of Fig. 4, grasped by hands that are not the nominal one.

python -m benchmarks.truth.objects --out FOLDER --grasps 10 --seed 1

Each grasp is another hand (see `scatter`) with a loose leader and a gear that rubs under load (both
hidden), and the object is placed again. Objects: ten_objects.toml. Beside the
recordings, evaluation.toml lists them with their classes, for `hannes evaluate`.
"""

import argparse
import sys
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.truth import bench
from benchmarks.truth.fitness import fit
from benchmarks.truth.parameters import nominal, to_si
from benchmarks.truth.protocol import PAPER, POOR, Condition
from benchmarks.truth.record import posed
from benchmarks.truth.scatter import normal, run_scatter, scatter
from benchmarks.truth.simulation import trace
from hannes.core.errors import ComputationFailed, HannesError
from hannes.core.io.atomic_files import write_text
from hannes.core.recording.recording import Recording

FILE = Path(__file__).with_name("ten_objects.toml")
HAND, RUN = 0.02, 0.005  # relative scatter of hands, and of a hand from run to run
TIMING = 0.2e-3  # s, scatter of a run's start
SEAT = 1.5e-3  # m, scatter of the object's place in x and y
CENTRE = {"sphere": (4e-3, -47e-3), "cylinder": (14e-3, -47e-3), "prism": (14e-3, -47e-3)}  # m
SLACK, GEAR = (0.5e-3, 3e-3), (0.01, 0.06)  # m; 1: hidden, uniform within
MOST_DRAWS = 200
BORDER = 5500.0  # N/m, between soft and rigid


@dataclass(frozen=True)
class Thing:
    """An object: name, class (rigid or soft), what the simulation takes of it (SI)."""

    name: str
    label: str
    values: Mapping[str, Any]

    @property
    def stem(self) -> str:
        """Name of its files."""
        return self.name.lower().replace(" ", "-")


def things(path: Path = FILE) -> list[Thing]:
    """The objects of a file such as ten_objects.toml."""
    return [_thing(each) for each in tomllib.loads(path.read_text(encoding="utf-8"))["object"]]


def _thing(table: Mapping[str, Any]) -> Thing:
    units = {"radius": "m", "stiffness": "N/m", "damping": "N s/m"}
    values: dict[str, Any] = {key: to_si(table[key], unit) for key, unit in units.items()}
    if "size" in table:
        sides = [to_si(side, "m") for side in table["size"]]
        values |= {"half_x": sides[0] / 2, "half_y": sides[1] / 2}
    return Thing(table["name"], table["class"], {"shape": table["shape"], **values})


def strangers(count: int, seed: int) -> list[Thing]:
    """Objects drawn at random, shapes in turn: of the sizes and materials that a hand meets."""
    rng = np.random.default_rng(seed)
    return [_stranger(rng, number, ("sphere", "cylinder", "prism")[number % 3])
            for number in range(count)]  # fmt: skip


def _stranger(rng: np.random.Generator, number: int, shape: str) -> Thing:
    ranges = {
        "sphere": {"radius": (31.5e-3, 36.5e-3)},
        "cylinder": {"radius": (17e-3, 30e-3)},
        "prism": {"radius": (3e-3, 11e-3), "half_x": (16e-3, 23.5e-3), "half_y": (16e-3, 22.5e-3)},
    }
    values = {name: float(rng.uniform(*ends)) for name, ends in ranges[shape].items()}
    values |= {
        "stiffness": float(np.exp(rng.uniform(*np.log([500.0, 38e3])))),
        "damping": float(np.exp(rng.uniform(*np.log([15.0, 190.0])))),
    }
    label = "rigid" if values["stiffness"] >= BORDER else "soft"
    return Thing(f"{shape} {number}", label, {"shape": shape, **values})


def grasp(
    thing: Thing,
    seed: Sequence[int],
    hand: Mapping[str, Any] | None = None,
    hidden: Mapping[str, float] | None = None,
) -> Recording:
    """One grasp of an object by `hand`, else by a hand of its own; the same for the same seed.

    `hidden`: sizes of effects by full name, else slack and gear loss at random.
    """
    rng = np.random.default_rng(seed)
    for _ in range(MOST_DRAWS):
        mine = hand or scatter(nominal(), rng, HAND)
        if not fit(mine):
            continue
        ran = _run(thing, mine, hidden, rng)
        if ran["force_N"][:50].max() == 0.0:  # not pressed before the hand moves
            condition = Condition(thing.name, PAPER, 1, None, sensor=True)
            return bench.logged(ran, condition, POOR, bench_hand(), rng)
    raise ComputationFailed(f"{thing.name}: none of {MOST_DRAWS} hands grasps it from clear")


def bench_hand() -> str:
    """What the bench believes of the hand."""
    return 'base = "hannes"\n'


def _run(
    thing: Thing,
    hand: Mapping[str, Any],
    hidden: Mapping[str, float] | None,
    rng: np.random.Generator,
) -> dict[str, np.ndarray]:
    place = np.array(CENTRE[thing.values["shape"]]) + SEAT * normal(rng, 2)
    own = {**thing.values, "position": (*place, 0.0)}
    before = {**posed(hand, own), "controller.current_step": bench.CURRENT_STEP}
    values, shift = run_scatter(before, rng, RUN, TIMING)
    condition = Condition(thing.name, PAPER, 1)
    ticks = round(condition.duration * 1000) + 1
    drawn = {
        "leader_slack.length": rng.uniform(*SLACK),
        "gear_load.coefficient": rng.uniform(*GEAR),
    }
    return trace(
        values,
        PAPER,
        object={"shape": thing.values["shape"]},
        duration=condition.duration,
        effects=drawn if hidden is None else hidden,
        current_noise=bench.CURRENT * rng.standard_normal(ticks),
        shift=shift,
    )[0]


def make(grasps: int, seed: int, chosen: Sequence[Thing] | None = None) -> dict[str, Recording]:
    """Recordings by name of file, some 0.1 s each."""
    from tqdm import tqdm

    plan = [(k, each, n) for k, each in enumerate(chosen or things()) for n in range(grasps)]
    return {
        f"{each.stem}-{n + 1:02d}": grasp(each, (seed, k, n))
        for k, each, n in tqdm(plan, "grasps", disable=None)
    }


def evaluation(chosen: Sequence[Thing]) -> str:
    """TOML that lists objects, classes and files."""
    blocks = [
        f'[[object]]\nname = "{each.name}"\nclass = "{each.label}"\nfile = "{each.stem}-*.h5"\n'
        f'stiffness = "{each.values["stiffness"]:g} N/m"\n'
        for each in chosen
    ]
    return (
        'title = "The ten objects of Fig. 4 (virtual, by the independent truth)"\n\n'
        + "\n".join(blocks)
    )


def main(words: Sequence[str] | None = None) -> int:
    """Exit status 0; 3 where a hand does not grasp."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.truth.objects",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--out", type=Path, required=True, help="folder for the recordings")
    parser.add_argument("--grasps", type=int, default=10, help="of each object")
    parser.add_argument("--seed", type=int, default=1)
    asked = parser.parse_args(words)
    try:
        for name, recording in make(asked.grasps, asked.seed).items():
            recording.write(asked.out / f"{name}.h5")
        write_text(asked.out / "evaluation.toml", evaluation(things()))
    except (HannesError, RuntimeError, OSError) as error:
        print(error, file=sys.stderr)
        return getattr(error, "exit_status", 3)
    return 0


if __name__ == "__main__":
    sys.exit(main())
