"""What `make audit` says of known faults: those found, and what could not be checked."""

import json

import pytest

from tools import advisories

SOUND = {"name": "numpy", "version": "2.0", "vulns": []}
FAULTY = {
    "name": "pillow",
    "version": "1.0",
    "vulns": [{"id": "CVE-1", "fix_versions": ["1.1"]}],
}
UNKNOWN = {"name": "scipy", "skip_reason": "not found"}


@pytest.mark.parametrize(
    ("rows", "status", "said"),
    [
        (None, 0, "known faults of the locked versions: NOT CHECKED"),
        ([UNKNOWN], 0, "known faults of the locked versions: NOT CHECKED"),
        ([SOUND, UNKNOWN], 0, "0 in 1; 1 NOT CHECKED"),
        ([SOUND], 0, "0 in 1 packages"),
        ([SOUND, FAULTY], 1, "pillow 1.0: CVE-1, mended in 1.1"),
    ],
)
def test_what_could_not_be_checked_is_not_called_sound(capsys, rows, status, said):
    answer = "" if rows is None else json.dumps({"dependencies": rows})
    assert advisories.main(lambda: answer) == status
    printed = capsys.readouterr().out
    assert said in printed and len(printed.splitlines()) == 1 + status
