"""Files as labs write them: from raw to `hannes check` by `hannes begin`, without code."""

import importlib.util

import numpy as np
import pytest
from shapes.samples import all_shapes, samples

from hannes.campaigns.begin.begin import CAMPAIGN, MAPPING
from hannes.campaigns.campaign_file import read_campaign
from hannes.commands.cli import main

DIGITS = {"reference": 2e-4, "position": 2e-3, "current": 2e-3}  # rad, rad (counts), A


@pytest.mark.parametrize("name", all_shapes())
def test_from_raw_to_check(name, tmp_path, capsys):
    shape = all_shapes()[name]
    if shape.needs and importlib.util.find_spec(shape.needs) is None:
        pytest.skip(f"needs {shape.needs}")
    files, out = shape.build(tmp_path, samples()), tmp_path / "bench"
    command = ["begin", *map(str, files), "--out", str(out)]
    assert main(command) == 0
    if shape.answers:
        text = (out / MAPPING).read_text()
        for asked, answer in shape.answers.items():
            assert asked in text
            text = text.replace(asked, answer, 1)
        (out / MAPPING).write_text(text)
        assert main(command) == 0
    said = capsys.readouterr().out
    assert "missing" not in said.split("next:")[-2 if shape.answers else 0] or shape.answers
    assert main(["check", str(out / CAMPAIGN)]) == 0
    entries = read_campaign(out / CAMPAIGN).entries
    assert len(entries) == shape.runs
    for number, entry in enumerate(entries):
        _same(entry.recording, samples(number))


def _same(recording, expected):
    assert recording.time - recording.time[0] == pytest.approx(expected.time, abs=1e-5)
    for channel, digits in DIGITS.items():
        values, wanted = recording[channel], getattr(expected, channel)
        apart = values - wanted
        if channel == "position":  # a counter begins anywhere
            apart = apart - np.median(apart)
        assert np.abs(apart).max() < digits, channel
