"""Diagnoses of real machines, judged on recordings that were never fitted.

EMPS, a motor-driven axis (Janot, Gautier & Brunot, 2019): one file is fitted, the second half of
its runs chooses, the other file is shown. The force error is 100 |measured - simulated| /
|measured| of the drive, pulses included, in closed loop from the recorded reference, start
position and speed from the record, 0.1 s to 0.05 s before the end.

RH56, a robot hand's middle finger (Correll Lab, Boulder, 2026): 35 commands of 20 trials. Trials
1 modulo 5 of each command (counted from 0) are fitted, 2 choose, 3 are shown; all samples, RMS in
the hand's own counts. The rows of models are fitted on trials 1 modulo 5 alone; the diagnosis
fits those that chose as well before it shows its result.

SO-101, elbow and jaw of a hobby arm (sage, 2026): stretches of six motions are fitted and choose,
four other motions are shown, run from the command alone; see benchmarks/real/so101.py.

Intervals are of the figure over the blocks of the recordings shown (1 s of the axis, a trial of
the finger), by resampling; that of the time constant is the verdict's. Pages are written to
results/benchmarks/real_machines. --quick takes one of five commands of the finger, and 8 s of each
stretch of the arm. --only chooses machines.
"""

import sys
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

from benchmarks.harness import Row, aligned, main
from benchmarks.real import axis, finger, so101
from hannes.campaigns.campaign import Campaign
from hannes.campaigns.campaign_file import read_campaign
from hannes.commands.diagnose import Diagnosis, diagnose
from hannes.core.errors import MissingRecording

PAGES = Path("results/benchmarks/real_machines")
QUICK = 5  # one of so many conditions
Figures = Callable[[Diagnosis], tuple[list[Row], list[Row]]]
MACHINES: dict[str, Figures] = {"emps": axis.figures, "rh56": finger.figures}
ARM = "so101"
PARTS = (*MACHINES, ARM)


def measure(quick: bool, only: Sequence[str] = PARTS) -> tuple[list[Row], list[Row]]:
    """Rows and what must be shown of every machine whose recordings are to be had."""
    rows: list[Row] = []
    bounds: list[Row] = []
    for name in only:
        try:
            more = so101.figures(PAGES, quick) if name == ARM else _shipped(name, quick)
        except MissingRecording as missing:
            print(f"{name} left out: {missing}", file=sys.stderr)
            continue
        rows, bounds = [*rows, *more[0]], [*bounds, *more[1]]
    return aligned(rows), aligned(bounds)


def _shipped(name: str, quick: bool) -> tuple[list[Row], list[Row]]:
    """Of a machine whose campaign ships."""
    campaign = read_campaign(name)
    found = diagnose(_fewer(campaign) if quick else campaign, out=PAGES / name)
    print(f"{name}: {found.verdict.sentence}", file=sys.stderr)
    return MACHINES[name](found)


def _fewer(campaign: Campaign) -> Campaign:
    """One of QUICK conditions, where there are so many."""
    conditions = list(dict.fromkeys(each.condition for each in campaign.entries))
    kept = conditions[::QUICK] if len(conditions) > QUICK else conditions
    return replace(
        campaign, entries=tuple(each for each in campaign.entries if each.condition in kept)
    )


if __name__ == "__main__":
    main(__doc__, "real_machines", measure, PARTS)
