"""Which lines of the README a release runs, and that none is forgotten."""

from tools.release_check import commands, missing, readme_lines, runnable, write_log

README = """\
Some `hannes prose` is no command.

```sh
python -m benchmarks.truth.closures --out results/closures  # made elsewhere
hannes diagnose results/closures/campaign.toml
make run
```

| you have | you type |
|---|---|
| nothing | `hannes reproduce`, `hannes effects` or `make run` |
"""


def test_commands_come_in_the_order_of_the_readme():
    assert readme_lines(README) == [
        "python -m benchmarks.truth.closures --out results/closures",
        "hannes diagnose results/closures/campaign.toml",
        "hannes reproduce",
        "hannes effects",
    ]


HELP = """\
usage: hannes [-h] COMMAND ...

positional arguments:
  COMMAND
    run        simulate
    experiments
               list the shipped
    train      learn

options:
"""


def test_a_command_without_a_line_is_seen():
    assert commands(HELP) == ["run", "experiments", "train"]
    assert missing(["hannes train data.h5", "hannes experiments"], commands(HELP)) == ["run"]


def test_what_waits_for_a_machine_only_shows_its_help():
    assert runnable(["hannes", "board", "--port", "x"]) == ["hannes", "board", "--help"]
    assert runnable(["hannes", "run", "x"]) == ["hannes", "run", "x"]


def test_the_log_that_convert_reads_is_a_closure(tmp_path):
    write_log(tmp_path)
    head, *rows = (tmp_path / "log.csv").read_text(encoding="utf-8").splitlines()
    assert head == "t [ms],i [mA],angle [deg]" and len(rows) > 500
