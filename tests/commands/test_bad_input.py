"""Bad input: one line on standard error, the right exit status, nothing written."""

import pytest

from hannes.commands.cli import main
from hannes.simulation.experiment import shipped

BALL = shipped.find("soft-ball").read_text(encoding="utf-8")


def refused(capsys, arguments, status=2):
    """The one line that a command says before it stops with `status`."""
    assert main([str(each) for each in arguments]) == status
    printed = capsys.readouterr()
    assert printed.out == ""
    (line,) = [each for each in printed.err.splitlines() if "compiling" not in each]
    assert line.startswith("hannes: ")
    return line


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("duration =", "durration =", 'did you mean "duration"'),
        ('"36 mm"', '"36 N"', "not a length"),
        ('"36 mm"', "36", "object.radius"),
        ('"800 N/m"', '"8e9 N/m"', "above its upper bound"),
        ('"36 mm"', '"60 mm"', "intersects the open hand"),
        ('"sphere"', '"spheer"', 'did you mean "sphere"'),
        ("effects = []", 'effects = ["leader_slak"]', 'did you mean "leader_slack"'),
        ('"continuous"', '"continuos"', "continuous"),
        ('points = [["0 s"', 'points = [["9 s"', "reference"),
    ],
)
def test_a_fault_in_an_experiment_is_one_line(tmp_path, capsys, old, new, said):
    assert old in BALL
    file = tmp_path / "mine.toml"
    file.write_text(BALL.replace(old, new, 1), encoding="utf-8")
    line = refused(capsys, ["run", file, "--out", tmp_path / "out"])
    assert said in line and "mine.toml" in line
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"time_s,current_A\n0,1\n1,x\n", "line 3"),
        (b"time_s,current_A\n0,1\n0,1\n", "line 3"),
        (b"time_s,current_A\n0,1\n1,nan\n", "line 3"),
        (b"\x00\x01\x02", "line 1"),
        (b"", "run.csv"),
    ],
)
def test_a_malformed_recording_is_one_line(tmp_path, capsys, content, said):
    (tmp_path / "run.csv").write_bytes(content)
    campaign = tmp_path / "campaign.toml"
    campaign.write_text('plant = "hand"\n[[recording]]\nfile = "run.csv"\n', encoding="utf-8")
    assert said in refused(capsys, ["diagnose", campaign, "--out", tmp_path / "out"])
    assert not (tmp_path / "out").exists()


def test_a_solver_that_gives_up_is_a_failed_computation(tmp_path, capsys, monkeypatch):
    import scipy.integrate

    class Failed:
        success, message, nfev, njev = False, "Required step size is too small.", 7, 0

        def __init__(self, start):
            import numpy as np

            self.y = np.asarray(start)[:, np.newaxis]
            self.t = np.zeros(1)

    monkeypatch.setattr(
        scipy.integrate, "solve_ivp", lambda fun, span, start, **rest: Failed(start)
    )
    asked = ["run", "dynamometer", "--method", "LSODA", "--out", tmp_path / "out"]
    line = refused(capsys, asked, status=3)
    assert "Required step size is too small." in line and "try" in line
    assert not (tmp_path / "out").exists()
