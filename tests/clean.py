"""Honest recordings, simulated by hannes and by the independent truth, that several tests spoil."""

import functools
import subprocess
import sys
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np

from hannes.core.recording.recording import Recording
from hannes.plants.axis.plant import Axis
from hannes.simulation.experiment.load import load_experiment
from hannes.simulation.hand.hand import Hand
from hannes.simulation.sensors import observe
from hannes.simulation.simulate import simulate

NOISE = {"current": 10e-3, "supply": 5e-3, "force": 0.2}


@functools.cache
def shipped(name, noisy=True):
    """The first run of a shipped experiment, with the sensors' noise."""
    experiment = load_experiment(name)[0].experiment
    experiment = replace(experiment, noise=NOISE if noisy else {}, seed=3)
    return observe(Hand(), simulate(Hand(), experiment))


@functools.cache
def truth_closure(seed=1, run=1):
    """A closure by the independent truth: another hand, sampled, counted, noisy."""
    return _closures(seed)[run - 1]


@functools.cache
def _closures(seed, runs=4):
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-m", "benchmarks.truth.closures", "--out", folder]
        command += ["--slack", "none", "--runs", str(runs), "--seed", str(seed)]
        subprocess.run(command, check=True, capture_output=True)
        files = sorted(Path(folder).glob("*_void.csv"))
        return [replace(Recording.read(file), plant="hand") for file in files]


@functools.cache
def swing(duration=4.0):
    """A run of the axis: three smooth strokes, an encoder's counts, noise on the drive."""
    time = np.arange(round(1000 * duration) + 1) / 1000.0
    phase = np.clip((time - 0.3) / (duration - 0.6), 0.0, 1.0)
    asked = 0.1 * np.sin(3.0 * np.pi * phase) ** 2
    blank = Recording(
        {"time": time, "reference": asked, "position": asked},
        {"time": "s", "reference": "m", "position": "m"},
        plant="axis",
    )
    run = Axis().simulate({}, blank)
    rng = np.random.default_rng(5)
    return blank.with_channels(
        {
            "position": np.round(run["position"] / 1e-6) * 1e-6,
            "drive": run["drive"] + 4e-3 * rng.standard_normal(time.size),
        },
        {"drive": "V"},
    )
