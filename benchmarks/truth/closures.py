"""Free closures of a hand whose leader wire may be slack, as CSV: a first campaign to diagnose.

python -m benchmarks.truth.closures --out FOLDER --slack "3 mm" --runs 6 --seed 1
"""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from benchmarks.truth.bench import experiment_text
from benchmarks.truth.campaign import Spread, make
from benchmarks.truth.hidden import hidden_from
from benchmarks.truth.protocol import closures
from hannes.core.errors import HannesError
from hannes.core.io.atomic_files import write_text

EXPERIMENT = "closure.toml"  # beside the recordings: CSV does not carry what was done


def main(words: Sequence[str] | None = None) -> int:
    """Exit status 0; 2 for bad input, 3 for a failed computation, with one line of why."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.truth.closures", description=__doc__
    )
    parser.add_argument("--out", type=Path, required=True, help="folder for the campaign")
    parser.add_argument("--slack", default="none", help='of the leader wire: "3 mm", or none')
    parser.add_argument("--runs", type=int, default=6)
    parser.add_argument("--seed", type=int, default=1)
    asked = parser.parse_args(words)
    slack = [] if asked.slack == "none" else [f"leader_slack.length={asked.slack}"]
    try:
        protocol = closures(asked.runs)
        made = make(protocol, asked.seed, hidden_from(slack), Spread(run=0.01))
        write_text(asked.out / EXPERIMENT, experiment_text(protocol.conditions[0]))
        made.write(asked.out, experiment=EXPERIMENT)
    except HannesError as error:
        print(error, file=sys.stderr)
        return error.exit_status
    return 0


if __name__ == "__main__":
    sys.exit(main())
