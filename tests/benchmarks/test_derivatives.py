"""What the closed form of the fingers' derivatives is compared with."""

from pathlib import Path

from benchmarks.derivatives import both, finger_hands
from hannes.simulation.catalogue import effects


def test_every_effect_in_the_fingers_has_a_row():
    hands = finger_hands()
    assert {"no effect", "spring_hysteresis", "hunt_crossley", "force_lag"} <= hands.keys()
    assert "leader_slack" not in hands
    assert len(hands[list(hands)[-1]].present_effects()) == len(effects())
    assert all(len(hand.present_effects()) == 1 for hand in list(hands.values())[1:-1])


def test_only_the_fingers_derivatives_differ():
    models = both((effects()["spring_hysteresis"],))
    texts = {way: Path(str(model.fast.__file__)).read_text() for way, model in models.items()}
    assert {model.jacobian_kind for model in models.values()} == {"structured"}
    assert "def joint_derivatives(" in texts["closed"] and "difference_own" not in texts["closed"]
    assert "def difference_own(" in texts["differenced"]
    assert "joint_derivatives" not in texts["differenced"]
    closed, differenced = (texts[way].partition("def finger_columns(")[0] for way in models)
    stages = [text[text.index("def equations(") :] for text in (closed, differenced)]
    assert stages[0] == stages[1]
