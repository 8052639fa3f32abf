"""What completes commands: a script that the shell itself takes, and that knows our words."""

import shutil
import subprocess

import pytest

from hannes.commands.cli import main


def completed(script, *words):
    """What bash offers after the words, in which the last one is begun."""
    line = f"{script}\nCOMP_WORDS=({' '.join(words)}); COMP_CWORD={len(words) - 1}\n"
    line += '_shtab_hannes\nprintf "%s\\n" "${COMPREPLY[@]}"'
    done = subprocess.run(["bash", "-c", line], capture_output=True, text=True, check=True)
    return done.stdout.split()


@pytest.mark.skipif(shutil.which("bash") is None, reason="no bash here")
def test_bash_completes_commands_experiments_and_options(capsys):
    assert main(["completion", "bash"]) == 0
    script = capsys.readouterr().out
    assert "reproduce" in completed(script, "hannes", "rep")
    assert completed(script, "hannes", "run", "dynamo") == ["dynamometer"]
    assert completed(script, "hannes", "diagnose", "em") == ["emps"]
    assert completed(script, "hannes", "effects", "leader") == ["leader_slack"]
    assert completed(script, "hannes", "view", "--experiment", "dynamo") == ["dynamometer"]
    assert "--still" in completed(script, "hannes", "view", "--st")


@pytest.mark.parametrize("shell", ["zsh", "tcsh"])
def test_other_shells_get_a_script(capsys, shell):
    assert main(["completion", shell]) == 0
    assert "calibrate" in capsys.readouterr().out
