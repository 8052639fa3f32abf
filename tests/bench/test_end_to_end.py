"""From a board with hidden slack to a hand file that fits it: through the port and the commands."""

import contextlib
import json
import subprocess
import sys

import numpy as np
import pytest
from drawn_model import drawn_model

from hannes import Hand, Recording, simulate
from hannes.bench.live_run import known_by
from hannes.bench.raw_log import RawLogReader
from hannes.commands.cli import main
from hannes.core.errors import BadInput
from hannes.plants.hand.recorded_experiment import experiment_of
from hannes.recognition import model_file
from hannes.recognition.known_hand import hand_numbers
from hannes.simulation.hand.hand_file import load_hand

CLOSURE = """
title = "Free closure"
hand = "hannes"
duration = "0.8 s"
sampling = "1 kHz"
controller = "sampled"
effects = []
[reference]
kind = "ramp"
points = [["0 s", "0 rad"], ["0.637 s", "9.84 rad"]]
"""
HIDDEN = (
    CLOSURE.replace("effects = []", 'effects = ["leader_slack"]')
    + """
[parameters]
"leader_slack.length" = "3 mm"
"controller.current_noise" = "10 mA"
"controller.noise_seed" = "{seed}"
"""
)


NOISE = 0.010  # A, as above


class Bench:
    """A folder, the closure's file, and boards that hide their slack."""

    def __init__(self, folder) -> None:
        self.folder = folder
        (folder / "closure.toml").write_text(CLOSURE)

    def record(self, name: str, seed: int) -> Recording:
        """`hannes board` in a process of its own, and `hannes record` from it."""
        hidden, out = self.folder / f"hidden{seed}.toml", self.folder / name
        hidden.write_text(HIDDEN.format(seed=seed))
        command = [sys.executable, "-m", "hannes", "board", str(hidden), "--tcp", "0"]
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as board:
            try:
                port = board.stdout.readline().strip()
                asked = ["record", str(self.folder / "closure.toml"), "--port", port]
                assert main([*asked, "--out", str(out)]) == 0
            finally:
                board.kill()
        return Recording.read(out)


def current_gap(recording: Recording, hand: Hand) -> float:
    """What the hand's simulation leaves of the measured current, beyond its noise; RMS [A]."""
    simulated = simulate(hand, experiment_of(recording)).require()
    current = np.interp(recording.time, simulated.time, simulated["current"])
    left = np.mean((recording["current"] - current) ** 2)
    return float(np.sqrt(max(left - NOISE**2, 0.0)))


@pytest.mark.slow
def test_hidden_slack_is_recorded_diagnosed_and_gone_on_new_recordings(tmp_path):
    bench, out = Bench(tmp_path), tmp_path / "diagnosis"
    for seed in range(1, 7):
        bench.record(f"closure_{seed}.h5", seed)
    campaign = tmp_path / "campaign.toml"
    campaign.write_text(
        'plant = "hand"\n[[recording]]\nfile = "closure_*.h5"\ncondition = "free closure"\n'
    )
    assert main(["check", str(campaign)]) == 0
    assert main(["diagnose", str(campaign), "--out", str(out)]) == 0
    verdict = json.loads((out / "verdict.json").read_text())
    assert (verdict["verdict"], verdict["effects"]) == ("named", ["leader_slack"])
    length = verdict["parameters"]["leader_slack.length"]
    assert length["value"] == pytest.approx(3e-3, rel=0.1)
    assert length["low"] < length["value"] < length["high"]
    updated = load_hand(out / "hand.toml")
    for seed in (21, 22):  # recorded from the board again, after the diagnosis
        new = bench.record(f"new_{seed}.h5", seed)
        before, after = current_gap(new, Hand()), current_gap(new, updated)
        print(f"current, beyond its noise: {1e3 * before:.1f} -> {1e3 * after:.1f} mA")
        assert after < 0.5 * before


def record_empty(port, path):
    """Record an empty closure; once more where a busy machine lost samples, as is asked for."""
    for _ in range(3):
        command = ["record", "empty-closure", "--port", port, "--out", str(path), "--force"]
        assert main(command) == 0
        with contextlib.suppress(BadInput):
            hand_numbers(Recording.read(path), drawn_model())
            return
        path.with_name(f"{path.name}.rawlog").unlink()


def test_a_hand_closes_on_nothing_and_is_known_as_it_grasps(tmp_path, capsys, monkeypatch):
    """`record empty-closure`, then `live --empty`, through one port: a virtual board's terminal."""
    monkeypatch.setattr("hannes.bench.live_run.BEHIND", 60.0)  # on a machine that does much else
    trained, hand, out = (tmp_path / f"{name}.h5" for name in ("model", "hand", "grasp"))
    model_file.write(trained, drawn_model())
    (tmp_path / "closure.toml").write_text(CLOSURE)
    command = [sys.executable, "-m", "hannes", "board", "void-closure"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as board:
        try:
            port = board.stdout.readline().strip()
            record_empty(port, hand)
            capsys.readouterr()
            live = ["live", port, str(trained), "--no-observer", "--empty", str(hand)]
            grasp = ["--close", str(tmp_path / "closure.toml"), "--out", str(out)]
            assert main([*live, *grasp]) == 0
            said = capsys.readouterr()
        finally:
            board.kill()
    again = tmp_path / "again.h5"  # from the raw bytes alone, as after a crash
    assert main(["record", "--recover", f"{hand}.rawlog", "--out", str(again)]) == 0
    assert Recording.read(again) == Recording.read(hand)
    log = RawLogReader(f"{out}.rawlog")
    numbers = known_by(log.about, drawn_model())
    log.close()
    assert np.array_equal(numbers, hand_numbers(Recording.read(hand), drawn_model()))
    assert Recording.read(out)["position"].max() > 2.0
    assert "P(rigid)" in said.out and "not known" not in said.err
