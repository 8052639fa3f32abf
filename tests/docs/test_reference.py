"""Pages that the code knows are up to date, and pages of keys list exactly the keys there are."""

import re

import pytest
from pages import ROOT, text

from tools.reference import FOLDER, PAGES, written


@pytest.mark.parametrize("page", sorted(PAGES))
def test_generated_pages_are_up_to_date(page):
    kept = FOLDER / page
    assert kept.exists() and text(kept) == written(page), "run `python -m tools.reference`"


def documented(page, heading):
    """Keys in the first column of the tables under a heading."""
    (section,) = re.findall(
        rf"^## {heading}\n(.*?)(?=^## |\Z)", text(page), re.MULTILINE | re.DOTALL
    )
    rows = re.findall(r"^\| (`[^|]+) \|", section, re.MULTILINE)
    return {key for row in rows for key in re.findall(r"`([\w.\"]+)`", row)}


def keys():
    """Page, heading, keys that the reader accepts."""
    from hannes.campaigns import campaign_file
    from hannes.campaigns.foreign import mapping_clock, mapping_file
    from hannes.dataset import spec
    from hannes.identification.calibration import settings as calibrate
    from hannes.identification.diagnosis import settings as diagnose
    from hannes.simulation.experiment import reader

    campaign, experiment = FOLDER / "campaign.md", FOLDER / "experiment.md"
    mapping, data = FOLDER / "mapping.md", FOLDER / "data-set.md"
    return [
        (campaign, "Campaign", campaign_file.KEYS),
        (campaign, "\\[\\[recording\\]\\]", campaign_file.RECORDING_KEYS),
        (campaign, "\\[calibrate\\]", calibrate.KEYS),
        (campaign, "\\[diagnose\\]", diagnose.KEYS),
        (experiment, "Experiment", reader.KEYS),
        (experiment, "\\[reference\\]", reader.REFERENCE),
        (experiment, "\\[object\\]", reader.OBJECT),
        (experiment, "material", reader.MATERIAL),
        (experiment, "size of a prism", reader.SIZE),
        (experiment, "\\[noise\\]", (*reader.NOISE, "seed")),
        (mapping, "Mapping", mapping_file.KEYS),
        (mapping, "\\[text\\]", mapping_clock.TEXT),
        (mapping, "\\[time\\]", mapping_clock.TIME),
        (mapping, "\\[channels.NAME\\]", mapping_file.CHANNEL),
        (mapping, "\\[files.NAME\\]", mapping_clock.FURTHER),
        (mapping, "\\[align\\]", mapping_file.ALIGN),
        (data, "Data set", spec.KEYS),
        (data, "\\[\\[grasps\\]\\]", spec.GROUP),
    ]


@pytest.mark.parametrize(("page", "heading", "known"), keys(), ids=lambda each: str(each)[-20:])
def test_the_keys_of_a_file_are_all_documented(page, heading, known):
    assert documented(page, heading) == set(known)


def test_a_missing_key_is_seen():
    page = ROOT / "docs" / "reference" / "campaign.md"
    assert documented(page, "Campaign") != {"title"}
