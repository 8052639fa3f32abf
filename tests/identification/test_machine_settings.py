"""What a campaign may say of its machine."""

from typing import ClassVar

import pytest
from sled import Sled, recordings

from hannes.core.errors import BadInput
from hannes.core.io.toml_table import Table
from hannes.identification.diagnosis.baseline import based
from hannes.identification.diagnosis.repeat_groups import grouped
from hannes.identification.diagnosis.settings import Settings, read_settings
from hannes.plants.axis.plant import Axis


def test_a_plant_whose_values_are_the_same_in_all_runs_can_be_refitted():
    class Steady(Sled):
        run_to_run: ClassVar = {}

    entries = [e for e in recordings(1) if e.role != "show"]
    plant = Steady()
    _, baseline = based(
        plant, grouped(plant, entries), Settings(0.02, 0.005), [], 0, lambda text: None
    )
    assert [rows.shape[0] for rows in baseline.noise.run_to_run] == [1, 1]  # their start alone


def test_a_plant_with_nothing_uncertain_takes_no_scatter():
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
        ({"work": 0}, "whole number from 1 to 50"),
        ({"work": "2"}, "without quotes"),
    ],
)
def test_what_a_campaign_says_of_its_machine_is_checked(content, message):
    with pytest.raises(BadInput, match=message):
        read_settings(Table(content, "campaign.toml", (), "diagnose."), Sled())
