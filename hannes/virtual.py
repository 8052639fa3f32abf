"""Recordings of an experiment that nobody made: simulated, and told as a bench would tell them."""

from dataclasses import replace
from pathlib import Path

from hannes.hand import Hand
from hannes.observe import observe
from hannes.recording import Recording
from hannes.simulate import simulate
from hannes.spec import load_experiment
from hannes.spec_text import experiment_toml


def virtual_recordings(name: str | Path) -> dict[str, Recording]:
    """Recordings by name of file, one for each variant of an experiment.

    They carry what was planned, not the hand that made them: its values are for the reader to
    find. Raises BadInput for an unknown experiment, ComputationFailed where one does not end.
    """
    made = {}
    for each in load_experiment(name):
        recording = observe(each.hand, simulate(each.hand, each.experiment).require())
        planned = experiment_toml(Hand(), replace(each.experiment, noise={}, seed=0))
        made[each.file] = replace(recording, experiment=planned, hand="", seed=None)
    return made
