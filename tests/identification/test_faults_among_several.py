"""A fault of one finger among several effects: other fingers are tried, or it is not named."""

from types import SimpleNamespace

import numpy as np

from hannes.identification.diagnosis import effect_removal
from hannes.identification.diagnosis.decision import Decision, _of_sure_parts, _shared
from hannes.identification.diagnosis.effect_removal import _with_like_faults
from hannes.identification.diagnosis.trials import Joint, Trial
from hannes.plants.hand.finger_faults import FAULTS
from hannes.simulation.catalogue import effects

EFFECTS = {**effects(), **FAULTS}
NAMED = ("current_offset", "middle_moved_stop")


def trial(names, delta_chi2):
    """A trial whose fit knows its effects alone."""
    point = SimpleNamespace(space=SimpleNamespace(effects=EFFECTS), x=np.zeros(1), chi2=1.0)
    return Trial(names, point, delta_chi2)


def test_it_is_tried_in_every_other_finger_once(monkeypatch):
    asked = []

    def transferred(baseline, leader, best, name):
        asked.append((best, name))
        return None if name.startswith("thumb") else leader

    monkeypatch.setattr(effect_removal, "transferred", transferred)
    monkeypatch.setattr(effect_removal, "priced", lambda baseline, made, factor: made)
    known = trial(("current_offset", "ring_moved_stop"), 900.0)
    found = SimpleNamespace(baseline=None, variance_factor=1.0)
    joint = Joint(trial(NAMED, 1000.0), others=(known,))
    made = _with_like_faults(found, joint, "middle_moved_stop", lambda text: None)
    fingers = ("index", "little", "thumb")
    assert sorted(asked) == [("middle_moved_stop", f"{each}_moved_stop") for each in fingers]
    assert [each.effects[1] for each in made.others] == [
        "ring_moved_stop", "index_moved_stop", "little_moved_stop",
    ]  # fmt: skip
    assert _with_like_faults(found, joint, "current_offset", lambda text: None) == joint


def test_it_is_sure_only_where_other_fingers_were_tried_and_do_less():
    untried = Joint(trial(NAMED, 1000.0), losses={name: 400.0 for name in NAMED})
    assert _shared(untried) == {"current_offset"}
    for delta_chi2, sure in ((500.0, set(NAMED)), (999.0, {"current_offset"})):
        other = trial(("current_offset", "ring_moved_stop"), delta_chi2)
        assert _shared(Joint(untried.trial, untried.losses, others=(other,))) == sure


def decided(names, per_bin, joint=None):
    """What becomes of a name with a remainder that leaves so much in 100 bins."""
    point = trial(names, 900.0).point
    point.chi2 = 100.0 * per_bin
    alone = trial(("current_offset",), 880.0)
    found = SimpleNamespace(bins=100, baseline="baseline", joint=joint, trials=[alone])
    decision = Decision("named_with_remainder", names, "so", point)
    return _of_sure_parts(found, decision)


def test_much_that_is_left_may_decide_which_finger_has_a_fault():
    stop = ("middle_moved_stop",)
    assert decided(stop, 1.2).effects == stop and decided(("current_offset",), 3.0).effects
    doubtful = decided(stop, 3.0)
    assert doubtful.kind == "unknown" and "which part has a fault" in doubtful.reason
    joint = Joint(trial(NAMED, 1000.0))
    kept = decided(NAMED, 3.0, joint)
    assert (kept.kind, kept.effects) == ("named_with_remainder", ("current_offset",))
