"""A model in C beside Python: words, votes and estimates of 10,000 grasps; size; cost of a tick.

Two in three grasps are of a data set: as they are, or disturbed (gain and offset of the current,
noise, a delay). The others are drawn closures. Instructions are counted by valgrind's callgrind
over the samples of 20 grasps; cycles by the processor's time-stamp counter, median and highest of a
tick over 200 grasps, on this machine.

    python -m benchmarks.export_c --dataset results/large.h5 --model results/large-model.h5
"""

import argparse
import re
import shutil
import struct
import subprocess
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from benchmarks.harness import Row, must_show, processor, table
from hannes.bench.c_vectors import drawn, last_estimates, windows
from hannes.bench.export_c import FLAGS, export_c
from hannes.dataset.read import DataSet, read
from hannes.recognition import model_file
from hannes.recognition.features import CHANNELS
from hannes.recognition.model import Model

ANSWER = np.dtype(
    [
        *((name, "u1") for name in ("word", "held", "stiff")),
        *((name, "<f8") for name in ("window", "rigid")),
        *((name, "<f8", 3) for name in ("stiffness", "force")),
    ]
)
AT_ONCE = 50
TICKS = """
#include <stdio.h>
#include <stdlib.h>
#include "model.c"
#ifdef __x86_64__
#include <x86intrin.h>
static uint64_t now(void) { return __rdtsc(); }
#else
static uint64_t now(void) { return 0; }
#endif
static int rising(const void *a, const void *b)
{
    uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
    return (x > y) - (x < y);
}
int main(void)
{
    static struct Hannes hand;
    static double samples[2000][3];
    static uint64_t spent[1000000];
    struct HannesDecision said;
    uint32_t count;
    size_t ticks = 0;
    while (fread(&count, 4, 1, stdin) == 1 && fread(samples, 24, count, stdin) == count) {
        hannes_reset(&hand);
        for (uint32_t k = 0; k < count && ticks < 1000000; k++) {
            uint64_t began = now();
            hannes_sample(&hand, samples[k][0], samples[k][1], samples[k][2], &said);
            spent[ticks++] = now() - began;
        }
    }
    qsort(spent, ticks, sizeof *spent, rising);
    double sum = 0.0;
    for (size_t k = 0; k < ticks; k++) sum += (double)spent[k];
    printf("%zu %.0f %llu %llu\\n", ticks, sum / (double)ticks,
           (unsigned long long)spent[ticks / 2],
           (unsigned long long)spent[ticks - 1 - ticks / 1000]);
    return 0;
}
"""


def grasps(data: DataSet, count: int) -> Iterator[np.ndarray]:
    """Samples (n, 3) of `count` grasps: of the data set, disturbed, drawn, in turn."""
    chance = np.random.default_rng(1)
    rows = chance.permutation(np.flatnonzero(data.usable))
    own = iter(())
    taken = 0
    for k in range(count):
        if k % 3 == 2:
            yield drawn(10_000 + k, data.time.size, float(np.median(np.diff(data.time))))
            continue
        block = next(own, None)
        if block is None:
            some = np.sort(rows[np.arange(taken, taken + 500) % rows.size])
            taken += 500
            own = iter(np.concatenate(list(data.blocks(some, CHANNELS))))
            block = next(own)
        yield block if k % 3 == 0 else disturbed(block, chance)


def disturbed(samples: np.ndarray, chance: np.random.Generator) -> np.ndarray:
    """The grasp by a machine that reads otherwise: current's gain and offset, noise, a delay."""
    late = int(chance.integers(0, 30))
    made = np.concatenate([np.repeat(samples[:1], late, axis=0), samples[: len(samples) - late]])
    made[:, 0] = made[:, 0] * chance.uniform(0.7, 1.3) + chance.normal(0.0, 0.02)
    made[:, 0] += chance.normal(0.0, 0.01, len(made))
    return made


def packed(some: list[np.ndarray]) -> bytes:
    """Grasps as the program reads them."""
    return b"".join(struct.pack("<I", len(each)) + each.astype("<f8").tobytes() for each in some)


def compared(model: Model, program: Path, samples: Iterator[np.ndarray], count: int) -> Row:
    """Python and C on `count` grasps: what differs, and by how much."""
    row: Row = dict.fromkeys(("grasps", "windows", "words", "votes"), 0)
    worst = {"rigid": 0.0, "stiffness": 0.0, "force": 0.0}
    said_of = np.zeros(3, int)
    for _ in range(0, count, AT_ONCE):
        some = [next(samples) for _ in range(min(AT_ONCE, count - row["grasps"]))]
        done = subprocess.run([program, "-"], input=packed(some), capture_output=True, check=True)
        each_said = np.frombuffer(done.stdout, ANSWER)
        for grasp in some:
            wanted = windows(model, grasp)
            said, each_said = each_said[: wanted.words.size], each_said[wanted.words.size :]
            row["grasps"] += 1
            row["windows"] += said.size
            row["words"] += int((said["word"] != wanted.words).sum())
            row["votes"] += int((said["window"] != wanted.window).sum())
            said_of += np.bincount(wanted.words, minlength=3)
            off = np.abs(said["rigid"] / wanted.rigid - 1.0).max()
            worst["rigid"] = max(worst["rigid"], float(off))
            for name, each in zip(
                ("stiffness", "force"), last_estimates(model, wanted), strict=True
            ):
                if each is not None:
                    at = said["stiff" if name == "stiffness" else "held"].astype(bool)
                    apart = np.abs(said[name][at][-1] / list(vars(each).values()) - 1.0).max()
                    worst[name] = max(worst[name], float(apart))
    words = dict(zip(("soft", "rigid words", "don't know"), map(int, said_of), strict=True))
    return row | words | {f"{name} off": each for name, each in worst.items()}


def sizes(program: Path) -> dict[str, int]:
    """Bytes of an object file by `size`: code with constants, and static data."""
    line = subprocess.run(["size", program], capture_output=True, text=True, check=True).stdout
    text, data, bss = (int(each) for each in line.splitlines()[1].split()[:3])
    return {"text": text, "data and bss": data + bss}


def counted(folder: Path, some: list[np.ndarray]) -> float | None:
    """Instructions a tick by valgrind's callgrind, None where there is no valgrind."""
    if shutil.which("valgrind") is None:
        return None
    command = ["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null",
               "--toggle-collect=hannes_sample", folder / "ticks"]  # fmt: skip
    done = subprocess.run(command, input=packed(some), capture_output=True, check=True)
    found = re.search(rb"Collected : (\d+)", done.stderr)
    assert found is not None
    return int(found[1]) / sum(map(len, some))


def main() -> None:
    """Build, compare, count; print a table."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.export_c", description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )  # fmt: skip
    parser.add_argument("--dataset", default="results/large.h5")
    parser.add_argument("--model", default="results/large-model.h5")
    parser.add_argument("--grasps", type=int, default=10_000)
    asked = parser.parse_args()
    model, data = model_file.read(asked.model), read(asked.dataset)
    made = export_c(model)
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        (folder / "model.c").write_text(made.text)
        (folder / "ticks.c").write_text(TICKS)
        flags = [*FLAGS.split(), "-g", "-fno-inline-functions-called-once"]
        for words in (
            ["-DHANNES_SELF_TEST", "model.c", "-o", "program", "-lm"],
            ["-c", "model.c", "-o", "model.o"],
            ["ticks.c", "-o", "ticks", "-lm"],
        ):
            subprocess.run(["cc", *flags, *words], cwd=folder, check=True)
        row = compared(model, folder / "program", grasps(data, asked.grasps), asked.grasps)
        some = list(grasps(data, 200))
        line = subprocess.run([folder / "ticks"], input=packed(some), capture_output=True)
        ticks, mean, median, high = map(int, line.stdout.split())
        cost = {"memory": made.memory_bytes, "trees": made.trees, "nodes": made.nodes}
        cost |= sizes(folder / "model.o") | {"ticks": ticks}
        cost |= {"cycles a tick": mean, "median": median, "99.9 %": high}
        cost["instructions a tick"] = counted(folder, some[:20]) or "no valgrind"
    bounds = [must_show("words that differ", row["words"], 0, row["words"] == 0)]
    print(table([row]), table([cost]), table(bounds), f"On {processor()}.", sep="\n\n")


if __name__ == "__main__":
    main()
