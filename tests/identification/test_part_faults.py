"""Faults of parts in a search: what they move in a simulation, and the other parts tried."""

from types import SimpleNamespace

import numpy as np
import pytest

from benchmarks.truth.campaign import Spread, make
from benchmarks.truth.faults import Fault
from hannes.commands.diagnose import diagnose
from hannes.identification.diagnosis import like_faults as module
from hannes.identification.diagnosis import trials
from hannes.identification.diagnosis.like_faults import varied, with_like_faults
from hannes.identification.diagnosis.parameter_space import ParameterSpace
from hannes.identification.diagnosis.reservations import ends_reached
from hannes.identification.diagnosis.score_test import Guess
from hannes.identification.diagnosis.settings import Settings
from hannes.identification.diagnosis.shortlist import next_laws, shortlist
from hannes.identification.diagnosis.trials import Trial, near, priced
from hannes.identification.diagnosis.tuning import SEARCH
from hannes.identification.effect_words import effect_words
from hannes.plants.hand.finger_faults import FAULTS
from hannes.plants.hand.other_settings import other_settings
from hannes.plants.hand.plant import HandPlant
from hannes.plants.part_fault import PartFault
from hannes.simulation.catalogue import effects
from hannes.simulation.hand.hand_file import hand_toml, load_hand

KNOWN = {**effects(), **FAULTS}

CHOSEN = [FAULTS["index_weak_spring"], FAULTS["thumb_moved_stop"]]
GROUP = SimpleNamespace(owner="", own=(), nominal={}, numbers=np.zeros(1))
REPEATED = SimpleNamespace(simulated_noise=False)


@pytest.fixture(scope="module")
def space():
    return ParameterSpace(HandPlant(), [GROUP], Settings(), CHOSEN)


def rows(space, **sizes):
    """Two points: the machine as given, and one with amplitudes at these sizes [SI]."""
    found = np.zeros((2, space.size))
    for name, size in sizes.items():
        place = space.place(name.replace("__", "."))
        found[1, place] = space.parameters[place].x(size)
    return found


def test_a_fault_moves_the_values_of_its_part(space):
    at = rows(space, index_weak_spring__mcp_lost=0.3, thumb_moved_stop__pip_angle=-0.2)
    columns = space.columns(GROUP, at, True)
    hand = HandPlant().parameters
    assert columns["index.mcp_spring_stiffness"] == pytest.approx([1.0, 0.7])
    assert columns["index.mcp_spring_preload"] == pytest.approx([1.0, 0.7])
    # The stop's angle is uncertain itself: the fault is added to what it is there.
    assert columns["thumb.end_pip"] == pytest.approx(hand["thumb.end_pip"] + np.array([0.0, -0.2]))
    assert not {"index.pip_spring_stiffness", "index_weak_spring.mcp_lost"} & columns.keys()


def test_without_effects_and_at_none_nothing_is_moved(space):
    at = rows(space, index_weak_spring__mcp_lost=0.3)
    assert "index.mcp_spring_stiffness" not in space.columns(GROUP, at, False)
    assert "index.mcp_spring_stiffness" not in space.columns(GROUP, at[:1], True)


def test_values_of_a_machine_are_within_bounds(space):
    at = rows(space, index_weak_spring__mcp_lost=0.4, thumb_moved_stop__pip_angle=-0.2)[1]
    values = space.values(at)
    assert values["index.mcp_spring_stiffness"] == pytest.approx(0.6)
    HandPlant().with_values(values)
    assert space.declared("thumb_moved_stop.pip_angle").unit == "rad"


@pytest.mark.slow  # a diagnosis of the whole catalogue
def test_a_lost_spring_is_named_with_its_finger_and_written_as_its_value(tmp_path):
    weak = Fault("weak_spring", "thumb", "mcp", 0.8)
    made = make("poor", 77, {}, Spread(finger=0.005), fault=weak)
    made.write(tmp_path)
    found = diagnose(tmp_path / "campaign.toml", progress=False)
    verdict = found.verdict
    assert verdict.verdict in ("named", "named_with_remainder")
    assert verdict.effects == ["thumb_weak_spring"]
    assert verdict.parameters["thumb_weak_spring.mcp_lost"]["value"] == pytest.approx(0.8, abs=0.05)
    (tmp_path / "found.toml").write_text(hand_toml(found.plant), encoding="utf-8")
    hand = load_hand(tmp_path / "found.toml")
    assert hand.parameters["thumb.mcp_spring_stiffness"] == pytest.approx(0.2, abs=0.05)


def at_end(space, name, size):
    """Ends of its range that an effect has reached at a size [SI]."""
    point = SimpleNamespace(
        space=space,
        x=rows(space, **{name: size})[1],
        model=SimpleNamespace(small=HandPlant()),
    )
    return list(ends_reached(point, [name.partition("__")[0]]).values())


def test_a_fault_is_at_the_end_of_its_range_unless_nothing_is_left_to_lose(space):
    assert at_end(space, "index_weak_spring__mcp_lost", 1.0) == []  # the spring is gone
    assert at_end(space, "index_weak_spring__mcp_lost", -1.0) == ["index weak spring's mcp lost"]
    low, _ = space.declared("thumb_moved_stop.mcp_angle").bounds
    assert at_end(space, "thumb_moved_stop__mcp_angle", low) == ["thumb moved stop's mcp angle"]
    hand = HandPlant()
    settings = list(other_settings(hand.parameters).values())
    other = ParameterSpace(hand, [GROUP], Settings(), settings)
    assert at_end(other, "mounting__along_y", -1.0) == ["mounting's along y"]
    assert at_end(other, "current_limit__change", -3.9) == ["current limit's change"]


def guess(name, delta_chi2=100.0):
    """Of an effect, so much promised."""
    return Guess(name, delta_chi2, *[np.zeros(0)] * 3)


def trial(*effects, delta_chi2=1000.0):
    """Effects fitted together."""
    space, residual = SimpleNamespace(effects=KNOWN), np.zeros(100)
    point = SimpleNamespace(space=space, chi2=1000.0, residual=residual)  # that leaves much
    return Trial(effects, point, delta_chi2)


def test_a_fault_of_the_little_finger_is_not_said_to_be_a_little_one():
    own = [name for name in FAULTS if name.startswith("little_")]
    assert own and all(effect_words(name).startswith("little finger's ") for name in own)
    assert effect_words("little_friction") == "little friction"


def test_alike_faults_leave_the_laws_their_places():
    faults = [guess(name, 500.0) for name in FAULTS]
    laws = [guess(name, 100.0 - k) for k, name in enumerate(effects())]
    baseline = SimpleNamespace(space=SimpleNamespace(effects=KNOWN))
    short = [each.effect for each in shortlist(baseline, [*faults, *laws])]
    assert short[: SEARCH.likely_faults] == [each.effect for each in faults[: SEARCH.likely_faults]]
    assert short[SEARCH.likely_faults :] == [each.effect for each in laws[: SEARCH.shortlist]]
    further = next_laws(baseline, [*faults, *laws])
    assert further == laws[SEARCH.shortlist : 2 * SEARCH.shortlist]


def test_of_the_same_fault_of_several_fingers_one_is_a_guess_at_what_is_left():
    names = ("ring_weak_spring", "index_weak_spring", "capstan", "index_moved_stop")
    found = varied(KNOWN, [guess(name) for name in names])
    assert [each.effect for each in found] == ["ring_weak_spring", "capstan", "index_moved_stop"]


def test_fingers_are_separated_by_chance_alone_and_laws_by_a_share():
    best = trial("thumb_weak_spring")
    others = [
        trial("index_weak_spring", delta_chi2=1000.0 - 0.9 * SEARCH.rival),
        trial("ring_weak_spring", delta_chi2=1000.0 - 2.0 * SEARCH.rival),
        trial("capstan", delta_chi2=1000.0 - 2.0 * SEARCH.rival),
    ]
    assert near(best, others) == [others[0], others[2]]


def test_of_pairs_the_finger_alone_makes_the_limit_narrow():
    best = trial("capstan", "thumb_weak_spring")
    others = [
        trial("capstan", "ring_weak_spring", delta_chi2=1000.0 - 2.0 * SEARCH.rival),
        trial("leader_slack", "ring_weak_spring", delta_chi2=1000.0 - 2.0 * SEARCH.rival),
    ]
    assert near(best, others) == others[1:]


def test_the_best_fault_is_tried_in_every_other_finger(monkeypatch):
    left = {"index": 1300.0, "middle": 99.5, "ring": 101.0, "little": 140.0, "thumb": 99.8}
    begun, converged = [], []

    def transferred(baseline, leader, best, name):
        begun.append((name, best))
        return SimpleNamespace(chi2=left[name.partition("_")[0]], last_reduction=1.0)

    def rounds(point):
        yield SimpleNamespace(chi2=point.chi2, last_reduction=0.1)
        converged.append(point.chi2)
        yield point

    monkeypatch.setattr(module, "transferred", transferred)
    monkeypatch.setattr(module, "rounds", rounds)
    monkeypatch.setattr(module, "_from_as_given", lambda n, b, fits, best, name: fits[name])
    baseline = SimpleNamespace(chi2=1200.0, space=SimpleNamespace(effects=KNOWN))
    fits = {"thumb_weak_spring": SimpleNamespace(chi2=100.0, last_reduction=1.0)}
    found = with_like_faults(baseline, baseline, fits, "thumb_weak_spring", lambda text: None)
    assert [name for name, _ in begun] == [f"{finger}_weak_spring" for finger in left]
    leaders = [best.partition("_")[0] for _, best in begun]
    # The better one goes on; the first was led by none, and starts from the best.
    assert leaders == ["thumb", "thumb", "middle", "middle", "middle"]
    assert set(found) == {
        f"{finger}_weak_spring" for finger in ("middle", "ring", "little", "thumb")
    }
    assert found["thumb_weak_spring"].chi2 == 99.8
    assert converged == [99.8, 99.5, 101.0]  # the others are far from as good
    assert with_like_faults(baseline, baseline, {"capstan": fits}, "capstan", print) == {
        "capstan": fits
    }


@pytest.mark.parametrize(
    ("above", "other", "left"),
    [
        (1.5 * SEARCH.rival, 101.0, 101.0),  # it had come to rest above its least
        (1.5 * SEARCH.rival, 130.0, 100.0 + 1.5 * SEARCH.rival),
        (0.5 * SEARCH.rival, 101.0, 100.0 + 0.5 * SEARCH.rival),  # it is in the class anyway
        (10.0 * SEARCH.rival, 101.0, 100.0 + 10.0 * SEARCH.rival),  # too far
    ],
)
def test_a_rival_that_is_a_little_worse_starts_from_the_machine_as_given_too(
    monkeypatch, above, other, left
):
    """At its own size (0.4), and at that of the best one (0.5), which leads lower."""
    monkeypatch.setattr(module, "with_noise", lambda nominal, noise: nominal)
    monkeypatch.setattr(module, "started_at", lambda given, own, size: float(size[0]))
    monkeypatch.setattr(module, "fitted", lambda point, steps: point)
    ends = {0.4: 140.0, 0.5: other}
    monkeypatch.setattr(module, "settled", lambda size, *_: SimpleNamespace(chi2=ends[size]))
    space = SimpleNamespace(of=lambda name: [0 if name == "ring_weak_spring" else 1])
    fits = {
        "index_weak_spring": SimpleNamespace(chi2=100.0, x=np.array([0.0, 0.5]), space=space),
        "ring_weak_spring": SimpleNamespace(
            chi2=100.0 + above, x=np.array([0.4, 0.0]), space=space, noise=None
        ),
    }
    baseline, names = SimpleNamespace(chi2=1000.0), ("index_weak_spring", "ring_weak_spring")
    assert module._from_as_given(None, baseline, fits, *names).chi2 == left


def test_a_fault_of_one_of_like_parts_costs_more_than_a_law():
    """Twenty are tried: chance gives the best of them more than it gives one law."""
    law = SimpleNamespace()
    fault = PartFault("index_worn", "", "", "", (), (), kind="worn")
    reductions = []
    for name, effect in (("slack", law), ("index_worn", fault)):
        space = SimpleNamespace(effects={name: effect}, of=lambda *names: np.arange(1))
        point = SimpleNamespace(chi2=70.0, space=space)
        baseline = SimpleNamespace(chi2=100.0, noise=REPEATED)
        reductions.append(priced(baseline, Trial((name,), point, 0.0), 1.0).delta_chi2)
    assert reductions == [30.0, 30.0 - SEARCH.fault_price]


@pytest.mark.parametrize(("lost", "paid"), [(2.0, 2.0), (50.0, SEARCH.parameter_price)])
def test_a_fault_of_one_joint_pays_nothing_for_the_other_that_does_nothing(monkeypatch, lost, paid):
    space = SimpleNamespace(effects=KNOWN, place=str, of=lambda *names: np.arange(2))
    point = SimpleNamespace(chi2=60.0, space=space)
    baseline = SimpleNamespace(chi2=100.0, noise=REPEATED)
    monkeypatch.setattr(trials, "wald", lambda point, places: lost if "mcp" in places[0] else 200.0)
    found = priced(baseline, Trial(("ring_slipped_wire",), point, 0.0), 1.0)
    assert found.delta_chi2 == 40.0 - SEARCH.fault_price - paid


def test_a_rival_pays_nothing_for_a_number_that_it_does_not_need(monkeypatch):
    """Of friction by direction the dry part alone does as much here, or both are needed."""
    lost = {"direction_friction.dry": 90.0, "direction_friction.viscous": 0.5}
    monkeypatch.setattr(trials, "wald", lambda point, places: lost[places[0]])
    best = trial("current_offset", delta_chi2=100.0)
    other = trial("direction_friction", delta_chi2=100.0 - SEARCH.rival - 1.0)
    other.point.space.place = lambda name: name
    assert near(best, [other]) == [other]
    lost["direction_friction.viscous"] = SEARCH.parameter_price + 1.0
    assert near(best, [other]) == []
