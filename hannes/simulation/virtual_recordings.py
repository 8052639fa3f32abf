"""Virtual recordings of an experiment: simulated, and logged as a bench would log them."""

from dataclasses import replace
from pathlib import Path

from hannes.core.recording.recording import Recording
from hannes.simulation.catalogue import laws_of_objects
from hannes.simulation.experiment.load import load_experiment
from hannes.simulation.experiment.writer import experiment_toml
from hannes.simulation.hand.hand import Hand
from hannes.simulation.sensors import observe
from hannes.simulation.simulate import simulate


def virtual_recordings(name: str | Path) -> dict[str, Recording]:
    """Recordings by name of file, one for each variant of an experiment.

    They carry what was planned, not the hand that made them: its values are for the reader to
    find. Raises BadInput for an unknown experiment, ComputationFailed where one does not end.
    """
    made = {}
    for each in load_experiment(name):
        recording = observe(each.hand, simulate(each.hand, each.experiment).require())
        planned = experiment_toml(_bare(each.hand), replace(each.experiment, noise={}, seed=0))
        made[each.file] = replace(recording, experiment=planned, hand="", seed=None)
    return made


def _bare(hand: Hand) -> Hand:
    """The shipped hand with those laws of `hand` that are its object's."""
    moving = [each for each in hand.present_effects() if each.name in laws_of_objects()]
    names = [each.full_name(own.name) for each in moving for own in each.parameters]
    return Hand(moving).with_values({name: hand.parameters[name] for name in names})
