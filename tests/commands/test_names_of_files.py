"""What a terminal would take for a command never reaches it by a file's name."""

import shutil

from hannes.commands.cli import main

ODD = "e\x1b[31mvil\nfake.csv"


def test_a_files_name_is_shown_on_one_line(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    text = "time_s,reference_rad,position_rad,current_A\n"
    text += "".join(f"{k / 100},{k / 100},{k / 100},{0.1 + k % 7 / 100}\n" for k in range(200))
    (tmp_path / "sound.csv").write_text(text)
    shutil.copy("sound.csv", f"{ODD}.csv")
    main(["check", f"{ODD}.csv"])
    shown = capsys.readouterr()
    assert "\x1b" not in shown.out + shown.err and "e?[31mvil?fake.csv.csv: " in shown.out
