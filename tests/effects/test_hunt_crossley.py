"""hunt_crossley: its equation written a second time, its signature in a run."""

from effect_contract import check_equations, check_loss, runs, touch


def deep(x, rate, k, exponent, dissipation):
    if x <= 0.0:
        return 0.0
    return k * x * (x / 1e-3) ** exponent * (1.0 + dissipation * rate) - k * x


def test_equation():
    check_equations("hunt_crossley", {"deepening": deep})


def test_signature():
    """Deeper than 1 mm, the ball is stiffer."""
    bare, run = runs("hunt_crossley", "soft ball", exponent=0.3)
    assert 1.2 < run["force"].max() / bare["force"].max() < 5.0**0.3
    assert touch(run) >= touch(bare)


def test_signature_of_dissipation():
    """Harder to press, softer to let go: more is lost, by a tenth of a newton or so."""
    bare, run = runs("hunt_crossley", "soft ball", dissipation=3.0)
    pressed, left = (run["force"] - bare["force"])[500:600], (run["force"] - bare["force"])[700:720]
    assert pressed.mean() > 0.1 > -0.1 > left.mean()
    assert run["power_contact_normal"].sum() > 1.02 * bare["power_contact_normal"].sum() > 0.0


def test_what_is_lost_to_it_stands_in_the_ledger():
    check_loss("hunt_crossley.dissipation", "contact_normal")
