"""The deep diagnosis on a machine simulated here: what it names and what it refuses."""

import functools
from dataclasses import replace
from pathlib import Path
from typing import ClassVar

import numpy as np
import pytest

from hannes._jit import kernel
from hannes.alike import alike, told
from hannes.axis import Axis
from hannes.campaign import Campaign, Entry
from hannes.catalogue import effects
from hannes.diagnose import diagnose
from hannes.diagnosis.drift import drifts
from hannes.diagnosis.fit import fitted
from hannes.diagnosis.groups import grouped
from hannes.diagnosis.heldout import held_out
from hannes.diagnosis.investigation import LIMIT, Trial, _back, _second, investigate, joined
from hannes.diagnosis.noise import Noise, of_repeats, white_levels
from hannes.diagnosis.point import differenced
from hannes.diagnosis.screen import likeness, projected, screened, shapes
from hannes.diagnosis.settings import Settings, read_settings
from hannes.effect import Effect, Term
from hannes.errors import BadInput
from hannes.parameter import Parameter
from hannes.plain_plant import PlainPlant
from hannes.recording import Recording
from hannes.table import Table

STEP, TIMES = 2e-3, np.arange(500) * 2e-3
UNITS = {"time": "s", "drive": "N", "position": "m", "speed": "m/s"}
ROLES = ("fit", "fit", "select", "show")


RATTLE = "rattled"  # a run that tells turbulence from what only rubs harder at a crawl


class Sled(PlainPlant):
    """A driven mass on a spring with drag; hard driven or hardly at all."""

    def proposals(self, recorded):
        assert set(recorded) == {"slow", "fast"}
        bare = {n: np.zeros(TIMES.size) for n in UNITS} | {"time": TIMES}
        drives = {"idle": 0.01 * np.sin(4.0 * TIMES), RATTLE: 60.0 * np.sin(9.0 * TIMES)}
        return {name: Recording(bare | {"drive": drive}, UNITS) for name, drive in drives.items()}

    name = "sled"
    channels = UNITS
    required = ("drive",)
    judged = ("position", "speed")
    base = (
        Parameter("sled.mass", 1.0, "kg", (0.1, 10.0), "of the sled"),
        Parameter("sled.drag", 2.0, "N s/m", (0.0, 20.0), "against the rail"),
        Parameter("spring.stiffness", 40.0, "N/m", (1.0, 400.0), "pulls it back"),
    )
    free: ClassVar = {"sled.mass": 0.03, "sled.drag": 0.06, "spring.stiffness": 1.2}
    uncertain: ClassVar = {"sled.mass": 1.0, "sled.drag": 2.0, "spring.stiffness": 40.0}
    restless: ClassVar = {"sled.drag": 0.02}
    block = 0.2
    open: ClassVar = {"force": ("speed", "position", "time")}

    def simulate(self, parameters, recording):
        p = self.parameters.with_values(parameters)
        mass, drag, stiffness = (p[each.name] for each in self.base)
        more, x, v = self.added("force", parameters), 0.0, 0.0
        position, speed = np.zeros(TIMES.size), np.zeros(TIMES.size)
        for k, (time, drive) in enumerate(
            zip(TIMES.tolist(), recording["drive"].tolist(), strict=True)
        ):
            position[k], speed[k] = x, v
            v += STEP * (drive - drag * v - stiffness * x + more(v, x, time)) / mass
            x += STEP * v
        return {"position": position, "speed": speed}


@kernel
def hardening(size, position):
    """Of the spring [N]."""
    return -size * position**3


@kernel
def turbulence(size, speed):
    """Quadratic drag [N]."""
    return -size * speed * abs(speed)


@kernel
def suction(size, speed):
    """Quadratic drag, told by a size below 0 [N]."""
    return size * speed * abs(speed)


@kernel
def nearly_turbulence(size, speed):
    """Quadratic drag until it is fast [N]."""
    return -size * speed * min(abs(speed), 2.0)


@kernel
def gust(size, time):
    """What no effect below is [N]."""
    return size * np.sin(23.0 * time)


@kernel
def washboard(size, count, position):
    """A rail with so many waves in a metre [N]."""
    return size * np.sin(2.0 * np.pi * count * position)


def effect(name, function, largest, unit):
    """An effect of one amplitude, from 0."""
    size = Parameter("size", 0.0, unit, (0.0, largest), "how much", off=0.0)
    return Effect(
        name, "made for a test", "F += ...", "none (2026)", (size,), (Term(function, ("force",)),)
    )


HARDENING = effect("hardening", hardening, 6000.0, "N/m^3")
TURBULENCE = effect("turbulence", turbulence, 30.0, "N s^2/m^2")
TWIN = effect("twin", turbulence, 30.0, "N s^2/m^2")
WAVES = Effect(
    "washboard", "made for a test", "F += size sin(2 pi count x)", "none (2026)",
    (
        Parameter("size", 0.0, "N", (0.0, 5.0), "how much", off=0.0),
        Parameter("count", 5.0, "1/m", (1.0, 60.0), "waves", tried=tuple(map(float, range(1, 40)))),
    ),
    (Term(washboard, ("force",)),),
)  # fmt: skip
WAVES_OF_23 = replace(
    WAVES, parameters=(WAVES.parameters[0], replace(WAVES.parameters[1], value=23.0))
)
GUST = effect("gust", gust, 5.0, "N")
KNOWN = {each.name: each for each in (HARDENING, TURBULENCE)}


def drives():
    """Two commands, each recorded four times."""
    return {
        "slow": 6.0 * np.sin(4.0 * TIMES),
        "fast": 12.0 * np.sign(np.sin(9.0 * TIMES)) * (TIMES < 0.8),
    }


@functools.cache
def recordings(seed, hidden=(), growth=0.0):
    """Entries of a scattered sled with hidden effects of given sizes, sensors noisy.

    growth: of the effects with every run, as a share of their size
    """
    rng = np.random.default_rng(seed)
    sled = Sled().with_effects(*(each for each, _ in hidden))
    machine = {
        name: sled.parameters[name] * (1.0 + 0.02 * rng.standard_normal())
        for name in Sled.uncertain
    }
    machine |= {each.full_name("size"): size for each, size in hidden}
    made = []
    for condition, drive in drives().items():
        for number, role in enumerate(ROLES):
            bare = Recording(
                {"time": TIMES, "drive": drive}, {n: UNITS[n] for n in ("time", "drive")}
            )
            own = {
                **machine,
                "sled.drag": machine["sled.drag"] * (1.0 + 0.005 * rng.standard_normal()),
            }
            for each, size in hidden:
                own[each.full_name("size")] = size * (1.0 + growth * len(made))
            run = sled.simulate(own, bare)
            noisy = {
                name: values + 2e-3 * rng.standard_normal(TIMES.size)
                for name, values in run.items()
            }
            recording = Recording({"time": TIMES, "drive": drive, **noisy}, UNITS)
            made.append(Entry(f"{condition}_{number}", recording, condition, role))
    return tuple(made)


def campaign(seed, hidden=(), known=KNOWN, growth=0.0):
    """A campaign of these, with what the bench says of its scatter."""
    said = Table({"scatter": "2 %", "run_scatter": "0.5 %"}, "campaign.toml", ())
    made = recordings(seed, hidden, growth)
    return Campaign(Sled(), Sled(), made, Path("out"), known, diagnose=said)


def found(seed, hidden=(), known=KNOWN, growth=0.0):
    """The verdict."""
    return diagnose(campaign(seed, hidden, known, growth), progress=False).verdict


@pytest.mark.parametrize(("hidden", "size"), [(HARDENING, 900.0), (TURBULENCE, 2.0)])
def test_a_hidden_effect_is_named_with_its_size(hidden, size):
    verdict = found(1, ((hidden, size),))
    assert (verdict.verdict, verdict.effects) == ("named", [hidden.name])
    told = verdict.parameters[f"{hidden.name}.size"]
    assert told["value"] == pytest.approx(size, rel=0.1) and told["low"] < size < told["high"]
    for gap in verdict.gap.values():
        assert gap["after"] < 1.2 * gap["floor"] and gap["after"] < gap["before"]


@pytest.mark.parametrize("seed", range(2, 8))
def test_nothing_is_named_on_a_machine_that_only_has_other_parameters(seed):
    verdict = found(seed)
    assert (verdict.verdict, verdict.effects) == ("recalibrated", [])


def test_a_machine_as_given_has_no_gap():
    entries = recordings(2)
    exact = Sled()
    made = []
    for k, entry in enumerate(entries):
        rng = np.random.default_rng([9, k])
        run = exact.simulate({}, entry.recording)
        noisy = {
            name: values + 2e-3 * rng.standard_normal(TIMES.size) for name, values in run.items()
        }
        recording = Recording({**entry.recording.channels, "time": TIMES, **noisy}, UNITS)
        made.append(Entry(entry.name, recording, entry.condition, entry.role))
    verdict = diagnose(
        Campaign(exact, exact, tuple(made), Path("out"), KNOWN), progress=False
    ).verdict
    assert verdict.verdict == "no_gap"


def test_two_effects_are_both_named():
    verdict = found(3, ((HARDENING, 900.0), (TURBULENCE, 2.0)))
    assert verdict.verdict == "named" and sorted(verdict.effects) == ["hardening", "turbulence"]


def test_a_first_effect_that_only_led_to_the_second_is_dropped():
    """Else a wrong name would stay beside the right one."""
    said = campaign(1, ((TURBULENCE, 2.0),))
    whole = investigate(said.plant, said.of("fit", "select"), list(KNOWN.values()), Settings(), 0)
    guess = next(each for each in whole.guesses if each.effect == "hardening")
    wrong = Trial(("hardening",), fitted(joined(whole.base, guess), 5), 1e3)
    again = _second(replace(whole, trials=[wrong]), lambda text: None)
    assert again.trials[0].effects == ("turbulence",) and again.pair is None
    assert again.trials[0].gain == pytest.approx(whole.trials[0].gain, rel=1e-3)


def test_what_no_effect_explains_is_unknown():
    verdict = found(4, ((GUST, 1.0),))
    assert (verdict.verdict, verdict.effects) == ("unknown", [])
    assert "per bin" in verdict.reason


def test_effects_that_do_the_same_make_a_class():
    known = {each.name: each for each in (HARDENING, TURBULENCE, TWIN)}
    verdict = found(5, ((TURBULENCE, 2.0),), known)
    assert verdict.verdict == "one_of" and sorted(verdict.effects) == ["turbulence", "twin"]
    alike = {row["effect"]: row["confusable_with"] for row in verdict.candidates}
    assert alike["turbulence"] == ["twin"] and alike["twin"] == ["turbulence"]


def test_of_two_effects_only_the_one_without_a_twin_is_named():
    known = {each.name: each for each in (HARDENING, TURBULENCE, TWIN)}
    verdict = found(3, ((HARDENING, 900.0), (TURBULENCE, 2.0)), known)
    assert (verdict.verdict, verdict.effects) == ("named_with_remainder", ["hardening"])
    assert "comes as near" in verdict.reason


def test_an_effect_that_is_off_at_its_upper_bound_is_tried():
    size = Parameter("size", 0.0, "N s^2/m^2", (-30.0, 0.0), "how much", off=0.0)
    wake = replace(TURBULENCE, name="wake", parameters=(size,), terms=(Term(suction, ("force",)),))
    verdict = found(1, ((TURBULENCE, 2.0),), {"hardening": HARDENING, "wake": wake})
    assert (verdict.verdict, verdict.effects) == ("named", ["wake"])


def test_the_next_run_is_the_one_that_tells_two_explanations_apart():
    nearly = effect("nearly", nearly_turbulence, 30.0, "N s^2/m^2")
    verdict = found(5, ((TURBULENCE, 2.0),), {"nearly": nearly, "turbulence": TURBULENCE})
    assert verdict.verdict == "one_of"
    assert verdict.next_run["experiment"] == RATTLE
    assert sorted(verdict.next_run["separates"]) == ["nearly", "turbulence"]
    assert "standard deviations" in verdict.next_run["why"]


def test_no_next_run_where_one_effect_is_named():
    assert found(1, ((HARDENING, 900.0),)).next_run is None


def test_what_looks_alike_is_told_and_shown(tmp_path):
    known = {each.name: each for each in (HARDENING, TURBULENCE, TWIN)}
    result = diagnose(
        campaign(5, ((TURBULENCE, 2.0),), known), out=tmp_path / "out", progress=False
    )
    told = result.verdict.confusability
    cosine = dict(zip(told["effects"], told["cosines"], strict=True))
    place = {name: k for k, name in enumerate(told["effects"])}
    assert cosine["twin"][place["turbulence"]] == pytest.approx(1.0, abs=2e-3)
    assert cosine["twin"][place["hardening"]] < 0.95
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert "What looks alike" in page and "<script" not in page


def test_show_recordings_change_nothing_but_the_gaps():
    whole = campaign(1, ((HARDENING, 900.0),))
    spoilt = tuple(
        Entry(e.name, shifted(e.recording), e.condition, e.role) if e.role == "show" else e
        for e in whole.entries
    )
    one, other = (
        diagnose(
            Campaign(Sled(), Sled(), each, Path("out"), KNOWN, diagnose=whole.diagnose),
            progress=False,
        )
        for each in (whole.entries, spoilt)
    )
    assert one.verdict.parameters == other.verdict.parameters
    assert one.verdict.effects == other.verdict.effects
    assert one.verdict.gap != other.verdict.gap


def shifted(recording):
    """The recording with its position moved."""
    return Recording(
        {**recording.channels, "position": recording["position"] + 0.05}, recording.units
    )


def test_the_same_seed_gives_the_same_verdict():
    assert found(6).json() == found(6).json()


@pytest.fixture(scope="module")
def investigated():
    """What an investigation of hidden turbulence finds."""
    entries = [e for e in recordings(1, ((TURBULENCE, 2.0),)) if e.role != "show"]
    return investigate(Sled(), entries, list(KNOWN.values()), Settings(0.02, 0.005), 0)


def test_slopes_are_those_of_the_simulation(investigated):
    base = investigated.base
    model, x = base.ground.model, base.x
    vectors, slopes = differenced(model, x, base.active, False)
    moved = x.copy()
    moved[0] += 0.1
    for group, vector, slope in zip(model.groups, vectors, slopes, strict=True):
        there = model.vectors(group, moved[np.newaxis], False)[0]
        moves = 0.1 * slope[0]
        assert there - vector == pytest.approx(moves, abs=0.03 * np.abs(moves).max())


def test_the_base_is_where_nothing_pulls(investigated):
    base = investigated.base
    step = np.linalg.solve(base.curvature, base.pull)
    assert step @ base.curvature @ step < 0.5
    assert base.misfit > 1.5 * base.miss.size  # an effect is missing
    assert investigated.trials[0].point.misfit < 1.2 * base.miss.size


def test_a_base_beside_its_best_place_is_led_back_by_an_effect(investigated):
    base = investigated.base
    beside = base.moved(base.x + 3.0 * np.isin(np.arange(base.x.size), base.active), base.active)
    assert beside.misfit > base.misfit + 20.0
    back = _back(replace(investigated, base=beside), lambda text: None)
    assert back.misfit == pytest.approx(base.misfit, abs=1.0)
    assert _back(investigated, lambda text: None) is None


def test_a_gain_is_of_what_was_not_fitted_too(investigated):
    base, best = investigated.base, investigated.trials[0].point
    seen, unseen = ([0b011] * 2, [0b100] * 2)
    assert held_out(base, best, seen, unseen) > LIMIT
    assert held_out(base, base, seen, unseen) == 0.0
    assert held_out(base, best, seen, [0, 0]) == 0.0


def test_what_grows_from_run_to_run_is_no_clean_name():
    verdict = found(1, ((TURBULENCE, 0.02),), growth=1.0)
    assert verdict.verdict in ("unknown", "named_with_remainder")
    assert "from run to run" in verdict.reason


def test_what_does_not_grow_does_not_drift(investigated):
    best = investigated.trials[0].point
    assert drifts(best, investigated.guesses).gain < LIMIT
    assert drifts(investigated.base, investigated.guesses).gain < 0.95 * investigated.trials[0].gain


def test_a_guess_agrees_with_the_refit_where_an_effect_is_small():
    entries = [e for e in recordings(1, ((TURBULENCE, 0.5),)) if e.role != "show"]
    small = investigate(Sled(), entries, list(KNOWN.values()), Settings(0.02, 0.005), 0)
    guess = next(each for each in small.guesses if each.effect == "turbulence")
    trial = next(each for each in small.trials if each.effects == ("turbulence",))
    assert guess.gain == pytest.approx(trial.gain * small.unit, rel=0.1)
    again = {g.effect: g.gain for g in screened(trial.point, ["hardening"])}
    assert again["hardening"] < LIMIT


def test_what_parameters_can_do_is_no_mark_of_an_effect(investigated):
    base = investigated.base
    row = base.columns[:1]
    _, curvature = projected(base, row)
    assert curvature[0, 0] < 1.01  # as much as the given value's own spread leaves of it
    assert likeness(base, row, row) == pytest.approx(1.0, abs=1e-3)


def test_noise_that_hangs_together_is_found_and_is_a_covariance():
    groups = grouped(Sled(), recordings(1))
    rng = np.random.default_rng(5)
    for group in groups:
        white = rng.standard_normal((group.count, group.part.size + 9))
        smooth = np.apply_along_axis(np.convolve, 1, white, np.ones(10) / np.sqrt(10.0), "valid")
        group.measured = 1e-2 * smooth
    none = [np.zeros((1, group.part.size)) for group in groups]
    calm = [each[0] for each in none]
    noise = Noise(groups, *of_repeats(groups, calm, none, 1.0), calm, none, 1.0)
    for group in groups:
        covariance = noise.covariance(group)
        assert np.linalg.eigvalsh(covariance).min() > 0.0
        near = np.diag(covariance, 1)[: group.bins - 1] / np.diag(covariance)[: group.bins - 1]
        assert 0.6 < near.mean() < 1.0
        assert np.sqrt(np.diag(covariance)).mean() == pytest.approx(1e-2, rel=0.3)


def test_noise_without_repeats_is_how_rough_samples_are():
    groups = grouped(Sled(), [recordings(1)[0], recordings(1)[4]])
    levels = white_levels(groups[0], {})
    per_bin = 2e-3 / np.sqrt(groups[0].recording.time.size / groups[0].bins)
    assert levels["position"] == pytest.approx(per_bin, rel=0.15)


def test_a_shape_that_is_a_count_is_found():
    verdict = found(1, ((WAVES_OF_23, 0.05),), {"washboard": WAVES})
    assert verdict.effects == ["washboard"]
    assert verdict.parameters["washboard.count"]["value"] == pytest.approx(23.0, abs=0.2)


def test_shapes_lie_inside_the_bounds():
    for each in effects().values():
        for shape in shapes(each):
            for name, value in shape.items():
                low, high = next(
                    p.bounds for p in each.parameters if each.full_name(p.name) == name
                )
                assert low <= value <= high
        assert shapes(each)


def test_a_plant_with_nothing_uncertain_is_not_told_how_much_of_it():
    with pytest.raises(BadInput, match="does not say what is uncertain"):
        read_settings(Table({"scatter": "2 %"}, "campaign.toml", (), "diagnose."), Axis())


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ({"scatter": "2"}, "scatter"),
        ({"scatter": "80 %"}, "between 0 and 50 %"),
        ({"scater": "2 %"}, "scatter"),
        ({"start_time": "2 mm"}, "start_time"),
        ({"start_time": "-1 ms"}, "not negative"),
    ],
)
def test_what_a_campaign_says_of_its_machine_is_checked(content, message):
    with pytest.raises(BadInput, match=message):
        read_settings(Table(content, "campaign.toml", (), "diagnose."), Sled())


def test_what_is_easily_confused_was_measured_both_ways():
    for effect in effects():
        for recorded, others in alike(effect).items():
            assert list(others.values()) == sorted(others.values(), reverse=True)
            for other, cosine in others.items():
                assert 0.0 < cosine <= 1.0
                assert alike(other)[recorded][effect] == pytest.approx(cosine, abs=2e-3)
    assert "capstan" in told("gear_load")
    assert told("nobody_knows") == ""
