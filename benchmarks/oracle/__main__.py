"""Write the smallest detectable size of every hidden effect, in both protocols, to a TOML file.

python -m benchmarks.oracle --resume
python -m benchmarks.oracle --effect NAME
python -m benchmarks.oracle --fingers-apart --resume

The second measures a new effect alone and writes benchmarks/oracle/sizes/NAME.toml: the file of all
effects belongs to the naming study, whose cases it fixes, and is made anew before a new study.
The third is of hands whose joints are each 1 % off for themselves, and writes fingers_apart.toml:
all effects of the catalogue and all settings, each searched from the size that fingers alike have.
A user who states nothing has the sizes of the poor protocol: the oracle knows the truth.

Where an effect has shapes, of each (see `shapes`). Some forty minutes on one core; --resume keeps
what an interrupted call has simulated, as long as the truth is the same.
"""

import argparse
import shutil
import tomllib
from pathlib import Path

import numpy as np
import tomli_w
from tqdm import tqdm

from benchmarks import truth
from benchmarks.oracle import APART, FOLDER, FROZEN
from benchmarks.oracle import bench as simulated
from benchmarks.oracle.bench import Bench
from benchmarks.oracle.discriminant import FALSE_ALARM, POWER, Discriminant
from benchmarks.oracle.expected_covariance import expected
from benchmarks.oracle.search import smallest
from benchmarks.oracle.shapes import Shape, shapes
from benchmarks.oracle.store import Store, digest
from benchmarks.truth.campaign import Spread
from benchmarks.truth.effects import OUTSIDE
from benchmarks.truth.hidden import SIZES
from benchmarks.truth.protocol import PROTOCOLS
from hannes.core.io.atomic_files import write_text

KEPT = Path("results/benchmarks/oracle")
EMPTIES, HANDS = 200, 3
FINGER = 0.01  # by which each joint is off for itself, where fingers are apart
BEYOND = "beyond the physical range"
Entries = dict[str, list[dict]]  # of each amplitude, by shape


def discriminant(bench: Bench, empties: int) -> Discriminant:
    """The oracle of a protocol, from its empty campaigns."""
    made = [bench.empty(k) for k in tqdm(range(empties), f"{bench.name}: empty campaigns")]
    return Discriminant(np.array(made), expected(bench, bench.spread))


def entry(
    bench: Bench, test: Discriminant, name: str, shape: Shape, hands: int, begin: float | None
) -> dict:
    """One shape of one effect of one protocol, as the file has it."""
    found, size = smallest(name, shape, bench, test, hands, begin), SIZES[name]
    sizes = {"u": found.u, **(found.found if len(found.found) > 1 else {})}
    return {
        **{key: BEYOND if u is None else float(f"{u:.3g}") for key, u in sizes.items()},
        "unit": size.unit,
        "low": size.low,
        "high": size.high,
        **({"shape": dict(shape)} if shape else {}),
    }


def searched(bench: Bench, asked: argparse.Namespace, before: Entries) -> Entries:
    """All effects of a protocol; the search begins where another protocol (`before`) ended."""
    test = discriminant(bench, asked.empties)
    found: Entries = {name: [] for name in amplitudes(asked)}
    for name, shape in tqdm([(n, s) for n in found for s in shapes(n)], bench.name):
        known = [e["u"] for e in before.get(name, []) if e.get("shape", {}) == shape]
        begin = next((u for u in known if u != BEYOND), None)
        found[name].append(entry(bench, test, name, shape, asked.hands, begin))
    return found


def amplitudes(asked: argparse.Namespace) -> list[str]:
    """Full names of amplitudes: of one effect, or of all that have a name."""
    outside = {each.__name__.rpartition(".")[2] for each in OUTSIDE}
    effects = {name: name.partition(".")[0] for name in SIZES if SIZES[name].amplitude}
    if asked.effect:
        return [name for name, effect in effects.items() if effect == asked.effect]
    left_out = outside if asked.fingers_apart else set()
    return [name for name, effect in effects.items() if effect not in left_out]


def spread_of(asked: argparse.Namespace) -> Spread:
    """How far hands differ."""
    return Spread(finger=FINGER) if asked.fingers_apart else Spread()


def head(asked: argparse.Namespace) -> dict:
    """What the file says of how it was made."""
    one = f" --effect {asked.effect}" if asked.effect else ""
    one += " --fingers-apart" if asked.fingers_apart else ""
    counts = f"--empties {asked.empties} --hands {asked.hands}"
    return {
        "made_by": f"python -m benchmarks.oracle {counts}{one}",
        "power": POWER,
        "false_alarm": FALSE_ALARM,
        "spread": vars(spread_of(asked)),
        "first_seed_of_empty_campaigns": simulated.EMPTY,
        "first_seed_of_hands_with_effects": simulated.HANDS,
    }


def main() -> None:
    """Simulate, search, write."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.oracle",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--resume", action="store_true", help="keep what is simulated already")
    parser.add_argument("--empties", type=int, default=EMPTIES, help="empty campaigns")
    parser.add_argument("--hands", type=int, default=HANDS, help="hands with each effect")
    parser.add_argument("--effect", metavar="NAME", help="this effect alone")
    parser.add_argument("--fingers-apart", action="store_true",
                        help="hands whose joints are each 1 %% off for themselves")  # fmt: skip
    parser.add_argument("--out", type=Path, help="default: where it belongs, see above")
    asked = parser.parse_args()
    if not amplitudes(asked):
        parser.error(f"no effect of the truth is named {asked.effect}")
    whole = APART if asked.fingers_apart else FROZEN
    out = asked.out or (FOLDER / f"{asked.effect}.toml" if asked.effect else whole)
    alike = tomllib.loads(FROZEN.read_text("utf-8")) if asked.fingers_apart else {}
    store = Store(KEPT / digest(Path(truth.__file__).parent))
    if not asked.resume:
        shutil.rmtree(store.folder, ignore_errors=True)
    found: dict[str, Entries] = {}
    for protocol in PROTOCOLS:
        before = next(iter(found.values()), {}) | alike.get(protocol, {})
        found[protocol] = searched(Bench(protocol, store, spread_of(asked)), asked, before)
        write_text(out, tomli_w.dumps(head(asked) | found))


if __name__ == "__main__":
    main()
