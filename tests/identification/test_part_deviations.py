"""What like parts are off for themselves joins the noise of all runs together."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from hannes.core.errors import BadInput
from hannes.core.io.toml_table import Table
from hannes.identification.diagnosis import fitted_deviations
from hannes.identification.diagnosis.fitted_deviations import deviations, with_deviations
from hannes.identification.diagnosis.heldout import _only
from hannes.identification.diagnosis.linearisation import Linearisation
from hannes.identification.diagnosis.noise_covariance import NoiseCovariance
from hannes.identification.diagnosis.part_deviations import PartDeviations, part_deviations
from hannes.identification.diagnosis.repeat_groups import _mirrored
from hannes.identification.diagnosis.settings import Settings, read_settings
from hannes.plants.hand.plant import HandPlant

BINS = (30, 20)
RNG = np.random.default_rng(2)
ROWS = [RNG.standard_normal((3, n)) for n in BINS]  # of three parts in two groups
NOISE = [np.diag(RNG.uniform(0.5, 2.0, n)) + 0.1 for n in BINS]
LEFT = [RNG.standard_normal(n) for n in BINS]


class Group(SimpleNamespace):
    """Bins are samples."""

    def vector(self, channels):
        return channels["position"]

    def only(self, runs):
        return Group(**{**vars(self), "count": len(runs)})


def noise(parts=True):
    groups = [
        Group(part=np.zeros(n), count=4, mean=left) for n, left in zip(BINS, LEFT, strict=True)
    ]
    names = ("index", "middle", "ring")
    changes = [
        {name: {"position": row} for name, row in zip(names, rows, strict=True)} for rows in ROWS
    ]
    space = SimpleNamespace(prior=np.ones(1), size=1)
    model = SimpleNamespace(groups=groups, space=space)
    model.of = lambda groups, numbers: SimpleNamespace(groups=groups, space=space)
    own = PartDeviations(changes) if parts else None
    rows = [np.zeros((1, n)) for n in BINS]
    return NoiseCovariance(model, None, [0.0, 0.0], NOISE, rows, True, own)


def whole(factor=1.0):
    """The covariance of both groups together."""
    covariance = np.zeros((sum(BINS), sum(BINS)))
    covariance[: BINS[0], : BINS[0]] = factor * NOISE[0]
    covariance[BINS[0] :, BINS[0] :] = factor * NOISE[1]
    rows = np.hstack(ROWS)
    return covariance + rows.T @ rows


def test_whitening_is_by_the_covariance_of_all_groups_together():
    white, left = noise().together(LEFT), np.concatenate(LEFT)
    assert white @ white == pytest.approx(left @ np.linalg.solve(whole(), left))
    alone = noise(parts=False).together(LEFT)
    assert alone @ alone > white @ white


def test_some_runs_keep_what_parts_differ_by():
    point = Linearisation(
        noise(), np.zeros(1), np.zeros(1, int), [np.zeros(n) for n in BINS],
        [np.zeros((1, n)) for n in BINS], noise().together(LEFT), np.zeros((1, sum(BINS))),
    )  # fmt: skip
    some = _only(point, [0, 3])  # two runs of the second group
    assert some.noise.parts.rows(some.noise.model.groups)[0] == pytest.approx(ROWS[1])


def test_a_part_that_one_command_does_not_move_is_zero_there():
    changes = [{"a": {"position": ROWS[0][0]}}, {"b": {"position": ROWS[1][0]}}]
    groups = noise().model.groups
    first, second = PartDeviations(changes).rows(groups)
    assert first[1] == pytest.approx(np.zeros(BINS[0])) and second[1] == pytest.approx(ROWS[1][0])


def test_a_plant_without_like_parts_has_none():
    model = SimpleNamespace(
        groups=[0],
        apart=lambda group, x, share: {},
        together=lambda group, x, share: [],
        parts_at={},
        space=SimpleNamespace(settings=Settings()),
    )
    assert part_deviations(model, np.zeros(1)) is None

    def up(size):
        return {"position": np.full(3, size)}

    model.apart = lambda group, x, share: {"a": (up(share), up(-0.5 * share))}
    found = part_deviations(model, np.zeros(1))
    odd, even = (each["position"] for each in found.changes[0].values())
    assert odd == pytest.approx(0.0075) and even == pytest.approx(0.0025)
    model.together = lambda group, x, share: [(up(3 * share), up(share)), (up(share), up(-share))]
    more = part_deviations(model, np.zeros(1)).changes[0]
    first, second = (more[f"all parts, draw {k}"]["position"] for k in (1, 2))
    assert first == pytest.approx(0.02 / 2**0.5) and second == pytest.approx(0.0)
    model.together = lambda group, x, share: [({}, up(share)), (up(3 * share), up(share))]
    rows = part_deviations(model, np.zeros(1)).changes[0]  # a machine keeps its number
    assert "all parts, draw 1" not in rows
    assert rows["all parts, draw 2"]["position"] == pytest.approx(0.02 / 2**0.5)
    model.space.settings = replace(Settings(), scatter_apart=0.0)
    assert part_deviations(model, np.zeros(1)) is None


def settings(**asked):
    return read_settings(Table(asked, "campaign.toml", ()), HandPlant())


def test_joints_are_off_by_a_hundredth_where_nothing_is_said_of_them():
    assert settings().scatter_apart == 0.01
    assert settings(scatter="2 %").scatter_apart == 0.01
    assert settings(scatter="2 %", scatter_apart="1 %").scatter_apart == 0.01
    assert settings(scatter_apart="0 %").scatter_apart == 0.0
    with pytest.raises(BadInput, match="scatter_apart"):
        settings(scatter_apart="60 %")


def test_before_a_touch_a_channel_is_as_uncertain_as_it_is_large_after_it():
    """A touch late in its bin leaves little there: the next bin says how uncertain it is."""
    force = np.array([0.0, 0.0, 0.0, 0.0, 1.0, 3.0, 9.0, 4.0, 0.0, 0.0])
    assert _mirrored(force, 3) == pytest.approx([0.0, 9.0, 9.0, 3.0, 0.0, 0.0, 0.0, 0.0, 9.0, 9.0])
    assert not _mirrored(force[:4], 3).any() and not _mirrored(force[4:8], 3).any()


def point(**fields):
    """A point whose simulations are zero."""
    zeros = [np.zeros(n) for n in BINS]
    return SimpleNamespace(noise=noise(**fields), vectors=zeros, x=np.zeros(1))


@pytest.mark.parametrize("factor", [1.0, 0.7])
def test_parts_are_as_off_as_the_fitted_recordings_have_them(factor):
    """Their mean given the recordings, by the covariance of all groups together."""
    found, rows, left = deviations(point(), factor), np.hstack(ROWS), np.concatenate(LEFT)
    assert list(found) == ["index", "middle", "ring"]
    wanted = rows @ np.linalg.solve(whole(factor), left)
    assert list(found.values()) == pytest.approx(wanted)


def test_runs_simulated_whole_carry_what_parts_are_off_by(monkeypatch):
    here = point()
    here.model = here.noise.model
    monkeypatch.setattr(fitted_deviations, "_command", lambda plant, group: id(group))
    monkeypatch.setattr(fitted_deviations, "grouped", lambda plant, entries: here.model.groups)
    here.model.small = None
    entries = [object() for _ in BINS]
    for group, entry in zip(here.model.groups, entries, strict=True):
        group.entries = (entry,)
    bare = [[{"position": np.zeros(n)}, {"position": np.zeros(n)}, None] for n in BINS]
    made = with_deviations(bare, entries, [here, here], 1.0)
    sizes = np.array(list(deviations(here, 1.0).values()))
    for each, rows in zip(made, ROWS, strict=True):
        assert not each[0]["position"].any() and each[2] is None  # as given; no run
        assert each[1]["position"] == pytest.approx(sizes @ rows)
    alone = point(parts=False)
    assert with_deviations(bare, entries, [alone, alone], 1.0) == bare
