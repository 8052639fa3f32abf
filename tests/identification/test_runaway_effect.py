"""An effect with which a machine runs away at some sizes is tried at the others."""

from dataclasses import replace
from typing import ClassVar

import numpy as np
from sled import HARDENING, TURBULENCE, Sled, campaign

from hannes.commands.diagnose import diagnose
from hannes.core.errors import ComputationFailed
from hannes.core.io.toml_table import Table
from hannes.core.parameter import Parameter
from hannes.identification.holdout.least_squares import differences

NOTHING_SAID = Table({}, "campaign.toml", ())


class Stopping(Sled):
    """A sled whose run ends where it leaves its rail; of it nothing is declared uncertain."""

    uncertain: ClassVar = {}
    longest: ClassVar = 3.0  # m

    def simulate(self, parameters, recording):
        run = super().simulate(parameters, recording)
        if not np.abs(run["position"]).max() < self.longest:
            raise ComputationFailed("the sled leaves its rail")
        return run


def effect(low):
    size = Parameter("size", 0.0, "N/m^3", (low, 6000.0), "how much", off=0.0)
    return replace(HARDENING, parameters=(size,))


def searched(plant, known):
    made = campaign(1, ((TURBULENCE, 2.0),), known)
    return diagnose(
        replace(made, plant=plant, shipped=plant, diagnose=NOTHING_SAID), progress=False
    ).verdict


def test_a_size_that_runs_away_ends_no_diagnosis():
    verdict = searched(Stopping(), {"turbulence": TURBULENCE, "hardening": effect(-6000.0)})
    assert verdict.effects == ["turbulence"]
    assert [each["effect"] for each in verdict.tried if each["why"] == "accepted"] == ["turbulence"]


def test_an_effect_that_never_runs_is_said_to_be_none_that_applies(monkeypatch):
    whole = Stopping.simulate

    def simulate(self, parameters, recording):
        if any(each.name == "hardening" for each in self.effects):
            raise ComputationFailed("the sled leaves its rail")
        return whole(self, parameters, recording)

    monkeypatch.setattr(Stopping, "simulate", simulate)
    verdict = searched(Stopping(), {"turbulence": TURBULENCE, "hardening": effect(0.0)})
    why = {each["effect"]: each["why"] for each in verdict.tried}
    assert verdict.effects == ["turbulence"]
    assert why["hardening"] == ("not applicable: a run with it fails: the sled leaves its rail")


def test_a_derivative_goes_the_way_on_which_a_run_succeeds():
    def data(x):
        return np.array([x @ x, x[0]]) if x[1] <= 1.0 and abs(x[2]) <= 1.0 else np.full(2, np.inf)

    low, high = np.full(3, -9.0), np.full(3, 9.0)
    found = differences(data, np.array([1.0, 1.0, 1.0]), low, high, 0.5)
    assert found.tolist() == [[2.5, 1.5, 1.5], [1.0, 0.0, 0.0]]
    alone = differences(data, np.array([1.0, 1.0, 1.0]), low, high, 3.0)
    assert np.all(alone[:, 2] == 0.0)
