"""`hannes compare`: the paper's metrics of a campaign's recordings, measured beside simulated."""

import json
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from hannes.campaigns.campaign import Campaign, Entry
from hannes.campaigns.campaign_file import read_campaign
from hannes.campaigns.warnings import campaign_warnings
from hannes.core.errors import BadInput, ComputationFailed
from hannes.core.io import atomic_files
from hannes.core.io.outputs import reserved
from hannes.identification.comparison.aligned_run import AlignedRun, aligned_run
from hannes.identification.comparison.comparison import Compared, conditions
from hannes.identification.comparison.run_metrics import run_metrics
from hannes.plants.hand.plant import HandPlant
from hannes.plants.hand.recorded_experiment import experiment_of

Progress = Callable[[str], None]


@dataclass(frozen=True, eq=False, repr=False)
class Comparison(Compared):
    """The result of `compare`: see identification/comparison/comparison.py; it can be written."""

    def write(self, folder: str | Path, force: bool = False) -> Path:
        """Write compare.json and index.html into `folder`, whole or not at all.

        `force`: results of another command there are replaced, too.
        """
        from hannes.report.comparison import page

        with atomic_files.atomic_folder(folder, "compare", force) as temporary:
            text = json.dumps(self.plain(), indent=1, ensure_ascii=False, allow_nan=False)
            (temporary / "compare.json").write_text(text + "\n", encoding="utf-8")
            (temporary / "index.html").write_text(page(self), encoding="utf-8")
        return Path(folder)

    def __repr__(self) -> str:
        count = len(self.campaign.entries)
        return f"Comparison({count} recordings, metrics: {', '.join(self.metrics) or 'none'})"


def compare(
    campaign: Campaign | str | Path,
    *,
    out: str | Path | None = None,
    progress: bool | None = None,
    force: bool = False,
    trust: bool = False,
) -> Comparison:
    """Compare a campaign of a hand, or the TOML file of one; writes to `out` where given.

    Each recording is simulated under its own command by the campaign's hand; nothing is fitted.
    `force`: results of another command in `out` are replaced, too. `trust`: Python that the TOML
    file names may run. `progress`: a bar on standard error, by default where that is a terminal.
    Raises BadInput for what cannot be used, which includes every fault of the data check;
    ComputationFailed where a simulation fails.
    """
    if not isinstance(campaign, Campaign):
        campaign = read_campaign(campaign, trust=trust)
    targets = [out] if out is not None else []
    with reserved("compare", targets, campaign.inputs, folder=True, force=force):
        result = _compared(campaign, progress)
        if out is not None:
            result.write(out, force)
    return result


def _compared(campaign: Campaign, progress: bool | None) -> Comparison:
    if not isinstance(campaign.plant, HandPlant):
        raise BadInput(
            f'the plant "{campaign.plant.name}" is no hand: Table II of the paper is about hands; '
            "`hannes diagnose` compares any plant"
        )
    units = dict.fromkeys(each.unit for each in campaign.entries)
    cautions = tuple(line for unit in units for line in campaign_warnings(_of(campaign, unit)))
    with _bar(len(campaign.entries), progress) as report:
        runs = _aligned(campaign, campaign.plant, report)
    return Comparison(campaign, conditions([run_metrics(each) for each in runs]), cautions)


def _of(campaign: Campaign, unit: str) -> Campaign:
    return replace(campaign, entries=tuple(e for e in campaign.entries if e.unit == unit))


def _aligned(campaign: Campaign, plant: HandPlant, report: Progress) -> list[AlignedRun]:
    """Every recording beside its simulation; one simulation serves all that it fits exactly."""
    known: dict[bytes, dict[str, np.ndarray]] = {}
    made = []
    for entry in campaign.entries:
        key = plant.same_run(entry.recording)
        if key not in known:
            known[key] = _simulated(plant, entry)
        made.append(aligned_run(entry, known[key], _stiffness(plant, entry)))
        report(entry.name)
    return made


def _simulated(plant: HandPlant, entry: Entry) -> dict[str, np.ndarray]:
    try:
        return plant.simulate({}, entry.recording)
    except ComputationFailed as error:
        raise ComputationFailed(f"{entry.name}: {error}") from None


def _stiffness(plant: HandPlant, entry: Entry) -> float | None:
    """Stiffness of a run's object [N/m], None where there is no object."""
    target = experiment_of(entry.recording).object
    if target is None:
        return None
    name = "object.stiffness"
    return float(target.values.get(name, plant.parameters[name]))


@contextmanager
def _bar(total: int, progress: bool | None) -> Iterator[Progress]:
    from hannes.core.io.progress import progress_bar

    hidden = None if progress is None else not progress
    with progress_bar(
        total=total, desc="comparing", unit=" runs", delay=2.0, disable=hidden, leave=False
    ) as bar:

        def report(text: str) -> None:
            bar.set_description(f"simulated {text}", refresh=False)
            bar.update()

        yield report
