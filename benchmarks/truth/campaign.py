"""A campaign of recordings of a hand in which something may be hidden, and its sealed answer.

python -m benchmarks.truth.campaign --protocol rich --out FOLDER --seed 1 \\
    --hide "leader_slack.length=3 mm"

The hand is the nominal one scattered, then scattered anew for each run (see `scatter`). A hand that
no longer grasps with drive to spare (see `fitness`) is drawn again, from the same generator, before
anything is hidden in it: the same seed is the same hand whatever is hidden. Nothing but
`sealed/answer.json` holds what is hidden.
"""

import argparse
import json
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.truth import bench
from benchmarks.truth.battery import FALL, drained
from benchmarks.truth.faults import Fault, broken
from benchmarks.truth.fitness import fit
from benchmarks.truth.hidden import hidden_from, of_effects
from benchmarks.truth.noise import current_noise
from benchmarks.truth.parameters import flat, parse_hand, to_si
from benchmarks.truth.protocol import PROTOCOLS, Condition, Protocol
from benchmarks.truth.record import checked, posed
from benchmarks.truth.scatter import LAWS, finger_scatter, run_scatter, scatter
from benchmarks.truth.settings import set_otherwise
from benchmarks.truth.simulation import trace
from benchmarks.truth.state import CREPT
from hannes.core.errors import BadInput, ComputationFailed, HannesError
from hannes.core.io.atomic_files import write_text
from hannes.core.recording.recording import Recording

SHIPPED = 'base = "hannes"\n'
MOST_DRAWS = 200
HAND, RUN, SENSORS, JOINTS = 0, 1, 2, 4  # streams of random numbers


@dataclass(frozen=True)
class Spread:
    """How far hands differ from the nominal one, and a hand from run to run.

    hand: standard deviation (law "normal") or half width ("uniform"), relative; run: standard
    deviation, relative; timing: standard deviation of a run's start (s); finger: standard
    deviation by which each joint's arm, spring and friction is off for itself, relative.
    """

    hand: float = 0.02
    law: str = "normal"
    run: float = 0.005
    timing: float = 0.2e-3
    finger: float = 0.0

    @property
    def lines(self) -> list[str]:
        """As a campaign says it; of what does not scatter it says nothing."""
        spreads = {
            "scatter": (100.0 * self.hand, "%"),
            "run_scatter": (100.0 * self.run, "%"),
            "start_time": (1e3 * self.timing, "ms"),
        }
        lines = [
            f'{key} = "{size:g} {unit}"' for key, (size, unit) in spreads.items() if size > 0.0
        ]
        return ["", "[diagnose]", *lines] if lines else []

    def times(self, factor: float) -> "Spread":
        """All of it so many times as wide."""
        return replace(
            self, hand=factor * self.hand, run=factor * self.run, timing=factor * self.timing
        )


@dataclass(frozen=True)
class Made:
    """Recordings by name of file, their conditions, the hand as it is believed, and the answer.

    assumed: the scatter of nominal values that the analyst is given.
    """

    recordings: dict[str, Recording] = field(repr=False)
    conditions: dict[str, str]
    hand: str
    answer: dict[str, Any] = field(repr=False)
    assumed: Spread = Spread()

    def write(self, out: Path, experiment: str = "") -> None:
        """Write recordings, hand.toml, campaign.toml and sealed/answer.json to a folder.

        Recordings are HDF5, which carries their experiments; where one `experiment` is named for
        all of them they are CSV, which does not.
        """
        suffix = ".csv" if experiment else ".h5"
        for name, recording in self.recordings.items():
            recording.write(out / (name + suffix))
        write_text(out / "hand.toml", self.hand)
        write_text(out / "campaign.toml", self._campaign(suffix, experiment))
        answer = json.dumps(self.answer, indent=1, sort_keys=True)
        write_text(out / "sealed" / "answer.json", answer + "\n")

    def write_unstated(self, out: Path, experiments: Mapping[str, str]) -> None:
        """The same by a user who states nothing: CSV, no hand, no scatter, shipped experiments.

        experiments: condition -> name of the shipped experiment that stands for it
        """
        lines = ['plant = "hand"', 'out = "diagnosis"']
        for name, condition in self.conditions.items():
            self.recordings[name].write(out / f"{name}.csv")
            lines += ["", "[[recording]]", f'file = "{name}.csv"', f'condition = "{condition}"']
            lines.append(f'experiment = "{experiments[condition]}"')
        write_text(out / "campaign.toml", "\n".join(lines) + "\n")

    def _campaign(self, suffix: str, experiment: str) -> str:
        lines = ['plant = "hand"', 'base = "hand.toml"', 'out = "diagnosis"']
        lines += self.assumed.lines
        for name, condition in self.conditions.items():
            lines += ["", "[[recording]]", f'file = "{name}{suffix}"', f'condition = "{condition}"']
            lines += [f'experiment = "{experiment}"'] if experiment else []
        return "\n".join(lines) + "\n"


def make(
    protocol: str | Protocol = "rich",
    seed: int = 1,
    hidden: Mapping[str, float] | None = None,
    spread: Spread | None = None,
    hand: str = SHIPPED,
    progress: bool = False,
    assumed: Spread | None = None,
    fault: Fault | None = None,
    bandwidth: float | None = None,
) -> Made:
    """Make a campaign in memory: some 1.5 s for a rich one.

    hidden: sizes by full name (SI), such as {"leader_slack.length": 3e-3}; see `hidden`.
    hand: TOML of the nominal hand; that, and how far it may be off (`assumed`; by default the real
    spread), is all that the analyst gets. fault: of one finger, see `faults`.
    bandwidth: of the current sensor's noise (Hz), see `noise`.
    Raises BadInput for what cannot be made, ComputationFailed where a run does not end or no hand
    near the nominal one grasps.
    """
    from tqdm import tqdm

    spread = spread or Spread()
    try:
        plan = PROTOCOLS[protocol] if isinstance(protocol, str) else protocol
        checked(of_effects(hidden or {}))
        nominal = parse_hand(hand)
    except (KeyError, ValueError) as error:
        raise BadInput(str(error)) from None
    values, refused = real_hand(nominal, seed, spread)
    values = broken(values, fault) if fault else values
    values = set_otherwise(values, hidden or {})
    objects = {c.name: real_object(values, c, seed, spread) for c in plan.conditions}
    made = Made(
        {}, {}, hand, _answer(seed, spread, hidden or {}, values, refused), assumed or spread
    )
    made.answer.update({"fault": vars(fault)} if fault else {})
    made.answer.update({"noise_bandwidth_hz": bandwidth} if bandwidth else {})
    crept = 0.0
    for k, condition in enumerate(tqdm(plan.runs, "runs", disable=not progress)):
        name = f"{k + 1:02d}_{condition.stem}"
        own = objects[condition.name]
        state = (crept, bandwidth)
        run, facts, crept = _run(values, condition, own, hidden or {}, (seed, k), spread, state)
        made.recordings[name] = bench.logged(
            run, condition, plan.channels, hand, np.random.default_rng([seed, SENSORS, k])
        )
        made.conditions[name] = condition.name
        made.answer["runs"].append({"file": name, "condition": condition.name, **facts})
    return made


def real_hand(nominal: Mapping[str, Any], seed: int, spread: Spread) -> tuple[dict[str, Any], int]:
    """A hand that grasps, and how many drawn before did not."""
    rng = np.random.default_rng([seed, HAND])
    for refused in range(MOST_DRAWS):
        values = scatter(nominal, rng, spread.hand, spread.law)
        joints = np.random.default_rng([seed, JOINTS, refused])
        values = finger_scatter(values, joints, spread.finger)
        if fit(values):
            return values, refused
    raise ComputationFailed(
        f"none of {MOST_DRAWS} hands scattered by {spread.hand:g} grasps with drive to spare; "
        "scatter less"
    )


def real_object(
    hand: Mapping[str, Any], condition: Condition, seed: int, spread: Spread
) -> dict[str, Any] | None:
    """The condition's object as it really is; one that is the hand's own is scattered with it."""
    if condition.thing is None or len(condition.thing) == 1:
        return dict(condition.thing) if condition.thing else None
    thing = {f"object.{name}": x for name, x in condition.thing.items() if name != "shape"}
    rng = np.random.default_rng([seed, HAND, 1])
    real = scatter(thing, rng, spread.hand, spread.law)
    return {"shape": condition.thing["shape"], **{k.partition(".")[2]: x for k, x in real.items()}}


def _run(
    hand: Mapping[str, Any],
    condition: Condition,
    thing: Mapping[str, Any] | None,
    hidden: Mapping[str, float],
    place: tuple[int, int],
    spread: Spread,
    state: tuple[float, float | None],
) -> tuple[dict[str, np.ndarray], dict[str, Any], float]:
    """One run: its channels, what the answer holds of it, and how long the leader is after.

    place: seed and number of the run; state: how long the leader is, bandwidth of the noise
    """
    crept, bandwidth = state
    before = {**posed(hand, thing), "controller.current_step": bench.CURRENT_STEP}
    before = drained(before, hidden, place[1]) if FALL in hidden else before
    rng = np.random.default_rng([place[0], RUN, place[1]])
    values, shift = run_scatter(before, rng, spread.run, spread.timing)
    noise = current_noise(rng, round(condition.duration * 1000) + 1, bandwidth)
    try:
        channels, states = trace(
            values,
            condition.points,
            object={"shape": thing["shape"]} if thing else None,
            duration=condition.duration,
            effects=of_effects(hidden),
            current_noise=noise,
            shift=shift,
            crept=crept,
        )
    except RuntimeError as error:
        raise ComputationFailed(f"run {place[1] + 1}, {condition.name}: {error}") from None
    changed = {name: value for name, value in values.items() if value != hand[name]}
    facts = {"late_s": shift, "crept_m": crept, "parameters": flat(changed)}
    return channels, facts, float(states[-1, CREPT])


def _answer(
    seed: int,
    spread: Spread,
    hidden: Mapping[str, float],
    hand: Mapping[str, Any],
    refused: int,
) -> dict[str, Any]:
    effects: dict[str, dict[str, float]] = {}
    for name, size in hidden.items():
        effect, _, parameter = name.partition(".")
        effects.setdefault(effect, {})[parameter] = float(size)
    return {
        "effects": effects,
        "hand": flat(hand),
        "hands_refused": refused,
        "runs": [],
        "seed": seed,
        "spread": vars(spread),
    }


def _arguments(words: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.truth.campaign",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--protocol", choices=PROTOCOLS, default="rich")
    parser.add_argument("--out", type=Path, required=True, help="folder for the campaign")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument(
        "--hide", nargs="+", action="extend", default=[], metavar="NAME=SIZE", help="effects"
    )
    parser.add_argument("--scatter-hand", type=float, default=0.02, metavar="SHARE")
    parser.add_argument("--law", choices=LAWS, default="normal", help="of the hand's scatter")
    parser.add_argument("--scatter-run", type=float, default=0.005, metavar="SHARE")
    parser.add_argument("--scatter-finger", type=float, default=0.0, metavar="SHARE",
                        help="of each joint for itself")  # fmt: skip
    parser.add_argument("--timing", default="0.2 ms", help="scatter of a run's start")
    parser.add_argument("--hand", type=Path, help="hand.toml of the nominal hand")
    return parser.parse_args(words)


def main(words: Sequence[str] | None = None) -> int:
    """Exit status 0; 2 for bad input, 3 for a failed computation, with one line of why."""
    asked = _arguments(words)
    try:
        timing = to_si(asked.timing, "s")
        spread = Spread(asked.scatter_hand, asked.law, asked.scatter_run, timing,
                        asked.scatter_finger)  # fmt: skip
        hand = asked.hand.read_text(encoding="utf-8") if asked.hand else SHIPPED
        hidden = hidden_from(asked.hide)
        made = make(asked.protocol, asked.seed, hidden, spread, hand, sys.stderr.isatty())
        made.write(asked.out)
    except (HannesError, ValueError, OSError) as error:
        print(error, file=sys.stderr)
        return getattr(error, "exit_status", 2)
    return 0


if __name__ == "__main__":
    sys.exit(main())
