"""A model in C: the same features, votes and words as Python's, in the memory that it states."""

import json
import re
import shutil
import struct
import subprocess
from dataclasses import replace

import numpy as np
import pytest
from drawn_model import HANDS, NUMBERS, drawn_model, drawn_networks

from hannes.bench.c_tables import LEFT_LEAF, RIGHT_LEAF, below, pack, short
from hannes.bench.c_vectors import drawn, last_estimates, windows
from hannes.bench.events import About, Row
from hannes.bench.export_c import FLAGS, export_c
from hannes.bench.live import LiveRecogniser
from hannes.bench.policy import GripMemory, GripSample, GripSettings, grip
from hannes.bench.release import Release
from hannes.commands.cli import main
from hannes.core.errors import BadInput
from hannes.dataset.empty_closure import empty_means
from hannes.recognition import model_file
from hannes.recognition.forest import Forest, single
from hannes.recognition.model import WORDS

COMPILER = shutil.which("cc") or shutil.which("gcc")
ANSWER = np.dtype(
    [
        *((name, "u1") for name in ("word", "held", "stiff")),
        *((name, "<f8") for name in ("window", "rigid")),
        *((name, "<f8", 3) for name in ("stiffness", "force")),
    ]
)


def built(model, folder):
    """The program that the exported file makes."""
    if COMPILER is None:
        pytest.skip("no C compiler on this machine")
    (folder / "model.c").write_text(export_c(model).text)
    flags = [*FLAGS.split(), "-Wall", "-Wextra", "-Werror", "-DHANNES_SELF_TEST"]
    subprocess.run([COMPILER, *flags, folder / "model.c", "-o", folder / "m", "-lm"], check=True)
    return folder / "m"


def answers(program, grasps):
    """What the program says of each window of grasps (n, samples, 3), shape (n, windows)."""
    given = b"".join(struct.pack("<I", len(each)) + each.astype("<f8").tobytes() for each in grasps)
    said = subprocess.run([program, "-"], input=given, capture_output=True, check=True).stdout
    return np.frombuffer(said, ANSWER).reshape(len(grasps), -1)


@pytest.fixture(scope="module")
def model():
    return drawn_model()


@pytest.fixture(scope="module")
def program(model, tmp_path_factory):
    return built(model, tmp_path_factory.mktemp("export"))


def test_its_test_vectors_hold(program):
    assert (
        "0 of 8 test vectors failed"
        in subprocess.run([program], capture_output=True, text=True, check=True).stdout
    )


def test_a_vector_that_is_wrong_fails(model, tmp_path):
    text = export_c(model).text
    wrong = re.sub(r"\{1u, 0x(.)", lambda m: "{1u, 0x" + ("0" if m[1] != "0" else "1"), text)
    assert wrong != text
    (tmp_path / "w.c").write_text(wrong)
    flags = [*FLAGS.split(), "-DHANNES_SELF_TEST", "-o", tmp_path / "w"]
    subprocess.run([COMPILER, *flags, tmp_path / "w.c", "-lm"], check=True)
    assert subprocess.run([tmp_path / "w"], capture_output=True).returncode == 1


def test_words_votes_and_estimates_are_those_of_python(model, program):
    grasps = [drawn(seed, 1150, 1e-3) for seed in range(1000, 1040)]
    for samples, said in zip(grasps, answers(program, grasps), strict=True):
        wanted = windows(model, samples)
        assert np.array_equal(said["word"], wanted.words)
        assert np.array_equal(said["window"], wanted.window)
        assert np.array_equal(said["held"].astype(bool), wanted.holds)
        assert said["rigid"] == pytest.approx(wanted.rigid, rel=1e-12)
        stiffness, force = last_estimates(model, wanted)
        assert said["stiffness"][-1] == pytest.approx(list(vars(stiffness).values()), rel=1e-12)
        last = said["force"][wanted.holds][-1]
        assert last == pytest.approx(list(vars(force).values()), rel=1e-12)


def test_all_words_occur_in_what_is_compared(model):
    words = np.concatenate([windows(model, drawn(k, 1150, 1e-3)).words for k in range(1000, 1040)])
    assert set(words) == {0, 1, 2}


def test_the_words_are_those_of_live_recognition(model):
    samples = drawn(7, 700, 1e-3)
    live, said = LiveRecogniser(model), []
    live.feed(About("x", {"current": "A", "position": "rad", "reference": "rad"}, 1000.0, 0.2))
    for k, row in enumerate(samples):
        said += live.feed(Row(k, 1e-3 * k, tuple(row)))
    wanted = windows(model, samples)
    assert [each.word for each in said] == [WORDS[word] for word in wanted.words]
    assert [each.rigid for each in said] == list(wanted.rigid)


@pytest.mark.parametrize("how", [(500.0, 0.08, 0.02), (1000.0, 0.21, 0.007)], ids=str)
def test_other_windows_too(how, tmp_path):
    model = drawn_model(*how)
    grasps = [drawn(seed, round(1.5 * how[0]), 1.0 / how[0]) for seed in range(5)]
    for samples, said in zip(grasps, answers(built(model, tmp_path), grasps), strict=True):
        wanted = windows(model, samples)
        assert np.array_equal(said["word"], wanted.words)
        assert np.array_equal(said["window"], wanted.window)


def test_nothing_is_allocated_and_memory_is_as_stated(model, program):
    made = export_c(model)
    assert not re.search(r"\b(malloc|calloc|realloc|alloca)\b", made.text)
    assert f"{made.memory_bytes} bytes in one struct Hannes, one struct HannesGrip" in made.text
    assert f"#define HANNES_MEMORY_BYTES {made.memory_bytes}u" in made.text


def leaf_of(packed, tree, row):
    """The leaf's value as C finds it."""
    node = packed.starts[tree]
    leaf, over = node + tree, node == packed.starts[tree + 1]
    while not over:
        what = int(packed.feature[node])
        if row[what % RIGHT_LEAF] <= packed.threshold[node]:
            over, node = bool(what & LEFT_LEAF), node + 1
        else:
            leaf += packed.left[node] + 1
            over, node = bool(what & RIGHT_LEAF), node + packed.left[node] + 1
    return packed.values[leaf]


def test_packed_trees_give_the_same_leaves(model):
    for forest in (model.rigid, model.stiffness, model.force):
        packed, chance = pack(forest), np.random.default_rng(2)
        spread = np.quantile(forest.threshold[forest.left >= 0], chance.random((200, 40)))
        rows, trees = spread.astype(np.float32), forest.starts.size - 1
        found = [np.mean([leaf_of(packed, tree, row) for tree in range(trees)]) for row in rows]
        assert found == pytest.approx(forest(rows), rel=1e-12)
        leaves = np.count_nonzero(forest.left < 0)
        assert packed.values.size == packed.left.size + trees <= leaves


def test_leaves_of_single_precision_are_smaller_and_the_same(model, tmp_path):
    parts = {name: single(getattr(model, name)) for name in ("rigid", "stiffness", "force")}
    small = replace(model, **parts)
    assert "const float *value;" in export_c(small).text
    assert export_c(small).table_bytes < export_c(model).table_bytes
    grasps = [drawn(seed, 1150, 1e-3) for seed in range(1000, 1010)]
    for samples, said in zip(grasps, answers(built(small, tmp_path), grasps), strict=True):
        wanted = windows(small, samples)
        assert np.array_equal(said["window"], wanted.window)
        stiffness, _ = last_estimates(small, wanted)
        assert said["stiffness"][-1] == pytest.approx(list(vars(stiffness).values()), rel=1e-12)


def test_leaves_of_one_value_under_one_node_are_joined():
    left, right = np.array([1, -1, 3, -1, -1]), np.array([2, 0, 4, 0, 0])
    value, threshold = np.array([0.0, 4.0, 0.0, 4.0, 4.0]), np.array([0.5, 0.0, 0.7, 0.0, 0.0])
    tree = Forest(np.array([0, 5]), left, right, np.zeros(5, int), threshold, value)
    assert pack(tree).values.tolist() == [4.0]
    apart = Forest(tree.starts, left, right, tree.feature, threshold, value + np.arange(5))
    assert pack(apart).values.tolist() == [5.0, 7.0, 8.0]


def test_a_tree_without_a_branch_and_unreached_nodes():
    one, two = np.array([-1, -1, -1]), np.zeros(3)
    forest = Forest(np.array([0, 1, 3]), one, one, np.zeros(3, int), two, np.array([5.0, 7.0, 9.0]))
    packed = pack(forest)
    assert [leaf_of(packed, tree, [0.0]) for tree in range(2)] == [5.0, 7.0]
    assert packed.values.tolist() == [5.0, 7.0]


def test_a_threshold_is_rounded_down_and_read_back():
    chance = np.random.default_rng(3)
    thresholds = np.concatenate([chance.normal(size=500), [0.1, -0.1, 1e300, -1e300, 0.0]])
    found = below(thresholds)
    assert (found <= thresholds).all()
    with np.errstate(over="ignore"):
        above = np.nextafter(found, np.float32(np.inf))
    assert (above > thresholds).all()
    finite = found[np.isfinite(found)]
    assert [np.float32(short(each).rstrip("f")) for each in finite] == list(finite)


def test_the_command(model, tmp_path, capsys):
    model_file.write(tmp_path / "model.h5", model)
    out = tmp_path / "hand.c"
    assert main(["export-c", str(tmp_path / "model.h5"), "--out", str(out), "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert said["trees"] == 29 and f"{said['memory_bytes']} bytes" in out.read_text()
    assert main(["export-c", str(tmp_path / "model.h5"), "--out", str(tmp_path / "x.txt")]) == 2
    assert "expected a file named .c" in capsys.readouterr().err
    assert (
        main(["export-c", str(tmp_path / "model.h5"), "--out", str(out)]) == 0
    )  # its own gives way
    assert main(["export-c", str(out), "--out", str(tmp_path / "y.c")]) == 2
    assert not (tmp_path / "y.c").exists()


PRESSED = """
#include <stdio.h>
#include "model.c"
int main(void)
{
    static struct Hannes hand;
    struct HannesDecision said = {0};
    double s[3];
    hannes_reset(&hand);
    while (fread(s, 8, 3, stdin) == 3) {
        if (hannes_sample(&hand, s[0], s[1], s[2], &said)) fwrite(said.pressed, 8, 3, stdout);
    }
    return 0;
}
"""


def ran(source, model, folder, samples):
    """Doubles that a program around the exported model says of samples."""
    (folder / "model.c").write_text(export_c(model).text)
    (folder / "own.c").write_text(source)
    flags = [*FLAGS.split(), "-Wno-unused-function", "-o", folder / "own"]
    subprocess.run([COMPILER, *flags, folder / "own.c", "-lm"], check=True)
    given = np.ascontiguousarray(samples).tobytes()
    return np.frombuffer(subprocess.run([folder / "own"], input=given, capture_output=True).stdout)


def live_pressed(model, samples, hand=None):
    """Stiffness by the traces with its ends [N/m] at each window, 0 before it is known."""
    live, said = LiveRecogniser(model, hand), []
    live.feed(About("x", {"current": "A", "position": "rad", "reference": "rad"}, 1000.0, 0.2))
    for k, row in enumerate(samples):
        said += live.feed(Row(k, 1e-3 * k, tuple(row)))
    return np.array([list(vars(d.pressed).values()) if d.pressed else [0.0] * 3 for d in said])


def test_the_stiffness_by_traces_is_that_of_live_recognition(model, program, tmp_path):
    values = []
    for seed in range(20, 26):
        samples = drawn(seed, 1150, 1e-3)
        wanted = live_pressed(model, samples)
        found = ran(PRESSED, model, tmp_path, samples).reshape(-1, 3)
        assert found == pytest.approx(wanted, rel=1e-14)
        assert np.array_equal(found > 0.0, wanted > 0.0)
        values += set(wanted[wanted[:, 0] > 0.0, 0])
    assert len(values) >= 4  # one a grasp, where the touch comes late enough
    assert min(values) < model.border < max(values)


def test_a_trace_that_is_out_of_reach_has_no_stiffness(model, program, tmp_path):
    samples = drawn(21, 1150, 1e-3)
    near = replace(model, pressed=replace(model.pressed, reach=np.array([1e-3] + [1.0] * HANDS)))
    assert live_pressed(model, samples).any() and not live_pressed(near, samples).any()
    assert not ran(PRESSED, near, tmp_path, samples).any()


KNOWN = """
#include <stdio.h>
#include "model.c"
int main(void)
{
    static struct HannesEmpty empty;
    static struct Hannes hand;
    struct HannesDecision said = {0};
    double s[3];
    hannes_empty_reset(&empty);
    for (int k = 0; k < 1600 && fread(s, 8, 3, stdin) == 3; k++)
        hannes_empty(&empty, s[0], s[1], s[2]);
    fwrite(empty.point, 8, HANNES_HAND, stdout);
    hannes_reset(&hand);
    hannes_know(&hand, &empty);
    while (fread(s, 8, 3, stdin) == 3) {
        if (hannes_sample(&hand, s[0], s[1], s[2], &said)) fwrite(said.pressed, 8, 3, stdout);
    }
    return 0;
}
"""


@pytest.mark.parametrize("reach", [1e3, 1e-3], ids=["known", "unlike all"])
def test_an_empty_closure_on_the_board_is_that_of_python(model, program, tmp_path, reach):
    model = replace(model, pressed=replace(model.pressed, reach=np.array([1e3] + [reach] * HANDS)))
    empty, samples = drawn(3, 1600, 1e-3), drawn(20, 1150, 1e-3)
    numbers = empty_means(*empty.T, 20, NUMBERS)
    points = model.pressed.points(numbers)
    assert (points is None) == (reach < 1.0)
    found = ran(KNOWN, model, tmp_path, np.concatenate([empty, samples]))
    if points is not None:
        assert np.array_equal(found[:HANDS], points)
    wanted = live_pressed(model, samples, None if points is None else numbers)
    assert wanted.any()
    assert found[HANDS:].reshape(-1, 3) == pytest.approx(wanted, rel=1e-14)
    if points is None:
        with pytest.raises(BadInput, match="unlike all"):
            LiveRecogniser(model, numbers)
    else:
        assert not np.array_equal(wanted, live_pressed(model, samples))


def test_a_model_that_knows_no_hands_has_no_empty_closure_in_c(model, tmp_path):
    alone = replace(model, pressed=drawn_networks(hands=0))
    built(alone, tmp_path)
    assert "HANNES_HAND 0" in export_c(alone).text
    assert export_c(alone).memory_bytes < export_c(model).memory_bytes


GRIP = """
#include <stdio.h>
#include "model.c"
int main(void)
{
    static struct HannesGrip grip;
    double s[10], point;
    hannes_grip_reset(&grip);
    while (fread(s, 8, 10, stdin) == 10) {
        struct HannesDecision said = {.touched = s[1] > 0.0, .held = s[1] > 0.0, .touch = s[2],
                                      .rigid = s[3], .force = {s[4], 0.0, s[5]},
                                      .pressed = {s[9] * HANNES_BORDER}};
        hannes_again(&grip, s[7]);
        point = hannes_grip(&grip, s[0] > 0.0 ? &said : NULL, 1e-3, s[6], s[7], s[8]);
        fwrite(&point, 8, 1, stdout);
    }
    return 0;
}
"""


def drawn_policy_samples(count):
    """Rows of fresh, touched, touch, rigid, force, its upper end, command, position, force set,
    stiffness over the border."""
    chance = np.random.default_rng(5)
    rows, closed = np.zeros((count, 10)), np.zeros((100, 10))
    closed[:, 6:8] = 9.0, 7.0  # a hand that begins closed, and touches nothing yet
    rigid, wanted, position = 0.5, 0.0, 0.0
    for k, row in enumerate(rows):
        rigid = min(max(rigid + chance.normal(0.0, 0.05), 0.0), 1.0)
        wanted += chance.uniform(-0.02, 0.024) - (0.009 if k % 2000 > 1500 else 0.0)
        position += 0.03 * (wanted - position)
        force = 20.0 * rigid + chance.uniform(0.0, 5.0)
        row[:] = (
            k % 10 == 0, chance.random() < 0.9, 1.0 + 0.001 * (k // 500), rigid, force, 1.2 * force,
            wanted, position, 15.0 if k // 1000 % 2 else 0.0,
            0.5 * (1 + k // 2000 % 4) if k % 1000 > 600 else 0.0,
        )  # fmt: skip
    return np.concatenate([closed, rows])


def test_the_grip_policy_has_the_bits_of_python(model, program, tmp_path):
    rows, memory, settings = drawn_policy_samples(8000), GripMemory(), GripSettings()
    held, force, wanted, release, released = None, (0.0, 0.0), [], Release(), 0
    for fresh, touched, touch, rigid, value, high, command, position, force_wanted, stiff in rows:
        release.begins(position)
        if fresh and touched and not release.is_open:
            held, force = (touch, rigid, stiff), (value, high)
        if held and release.lets_go(held[0], position):
            held, released = None, released + 1
        touch_, rigid_, stiff_ = held or (0.0, 0.5, 0.0)
        known = (held is not None, touch_, rigid_)
        sample = GripSample(1e-3, command, position, *known, *force, force_wanted, stiff_)
        memory, point = grip(settings, memory, sample)
        wanted.append(point)
    (tmp_path / "model.c").write_text(export_c(model).text)
    (tmp_path / "grip.c").write_text(GRIP)
    flags = [*FLAGS.split(), "-Wno-unused-function", "-o", tmp_path / "grip"]
    subprocess.run([COMPILER, *flags, tmp_path / "grip.c", "-lm"], check=True)
    done = subprocess.run(
        [tmp_path / "grip"], input=rows.tobytes(), capture_output=True, check=True
    )
    assert np.array_equal(np.frombuffer(done.stdout), wanted)
    assert released > 1
    assert 0.1 < np.mean(np.array(wanted) != rows[:, 6]) < 1.0  # it limits in part of them
