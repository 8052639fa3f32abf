"""An experiment of a user's own in Python, before the packages."""

from hannes.experiment import Experiment, Reference
from hannes.hand import Hand
from hannes.observe import observe
from hannes.simulate import simulate

hand = Hand().with_values({"motor.resistance": 0.5})
reference = Reference([[0.0, 0.02], [0.0, 0.2]])
recording = observe(hand, simulate(hand, Experiment("a start", 0.02, reference)))
