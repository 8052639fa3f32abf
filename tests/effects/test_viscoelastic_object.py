"""viscoelastic_object: its equation written a second time, its signature in a run."""

from effect_contract import check_equations, check_loss, runs


def crept(x, k, state, share, time):
    d = share * state
    return -k * d, (share * max(0.0, x - d) - d) / time / share


def test_equation():
    check_equations("viscoelastic_object", {"creeping": crept})


def test_signature():
    """Held, the grip on the ball fades."""
    bare, run = runs("viscoelastic_object", "held ball", share=0.5)
    fades = [r["force"][1450] / r["force"][700] for r in (bare, run)]
    assert fades[1] < fades[0] - 0.05
    assert run["force"].max() < bare["force"].max()


def test_what_is_lost_to_it_stands_in_the_ledger():
    check_loss("viscoelastic_object.share", "contact_normal")
