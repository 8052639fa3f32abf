"""Find where simulation and recordings disagree, and which effect the model is missing.

A plant that declares what of it is uncertain is diagnosed by fits of everything uncertain
(identification/diagnosis). Others are diagnosed by hold-out (identification/holdout).
"""

from dataclasses import dataclass, field, replace
from pathlib import Path

from hannes.campaigns.campaign import Campaign
from hannes.campaigns.campaign_file import read_campaign
from hannes.campaigns.segments import split_campaign
from hannes.campaigns.undeclared import said
from hannes.campaigns.warnings import campaign_warnings
from hannes.core import former_names
from hannes.core.by_value import ByValue
from hannes.core.io import atomic_files
from hannes.core.io.outputs import reserved
from hannes.core.io.progress import stages
from hannes.identification.diagnosis.campaign_diagnosis import (
    Result,
    declares_uncertainty,
    diagnose_campaign,
)
from hannes.identification.diagnosis.settings import Settings, read_settings
from hannes.identification.holdout.decision import lacking
from hannes.identification.holdout.diagnosis import diagnose_by_holdout
from hannes.identification.holdout.effect_test import Trial
from hannes.identification.holdout.least_squares import Progress
from hannes.identification.residuals import Traces
from hannes.identification.shape_words import description_caution
from hannes.identification.verdict import Verdict
from hannes.plants.plant_file import plant_toml
from hannes.plants.protocol import Plant


@former_names.attributes({"floors": "noise_floors", "deep": "details"})
@dataclass(frozen=True, eq=False, repr=False)
class Diagnosis(ByValue):
    """The verdict, the plant with what was found, and everything needed to draw it.

    details: what the verdict follows from, where the plant declares what of it is uncertain.
    """

    campaign: Campaign = field(compare=False)
    verdict: Verdict
    plant: Plant
    traces: tuple[Traces, ...]
    noise_floors: dict[str, float]
    trials: tuple[Trial, ...] = field(compare=False)
    details: Result | None = field(default=None, compare=False)

    def __repr__(self) -> str:
        found = ", ".join([self.verdict.verdict, *self.verdict.effects])
        return f"Diagnosis({found}; {len(self.campaign.entries)} recordings)"

    def write(self, folder: str | Path, force: bool = False) -> Path:
        """Write verdict.json, hand.toml, report.html into `folder`, whole or not at all.

        `force`: results of another command there are replaced, too.
        """
        from hannes.report.diagnosis import page

        with atomic_files.atomic_folder(folder, "diagnose", force) as temporary:
            (temporary / "verdict.json").write_text(self.verdict.json(), encoding="utf-8")
            (temporary / "hand.toml").write_text(self.toml(folder), encoding="utf-8")
            (temporary / "report.html").write_text(page(self), encoding="utf-8")
        return Path(folder)

    def toml(self, folder: str | Path | None = None) -> str:
        """Text of the hand.toml of `plant`, to lie in `folder`."""
        return plant_toml(self.plant, self.campaign.shipped, self.campaign.base, folder)


def diagnose(
    campaign: Campaign | str | Path,
    *,
    out: str | Path | None = None,
    seed: int = 0,
    progress: bool | None = None,
    force: bool = False,
    trust: bool = False,
    describe: bool = False,
) -> Diagnosis:
    """Diagnose a campaign, or the TOML file of one; writes to `out` where given.

    `force`: results of another command in `out` are replaced, too. `trust`: Python that the TOML
    file names may run. `progress`: True: a bar on standard error, or where that is no terminal one
    line a stage; by default the bar alone. `describe`: where nothing can be named, the plant takes
    the likeliest generic disturbance, and a caution says so.
    Raises BadInput for what cannot be used, which includes every fault of the data check;
    ComputationFailed where a simulation fails.
    """
    if not isinstance(campaign, Campaign):
        campaign = read_campaign(campaign, seed, trust=trust)
    targets = [out] if out is not None else []
    with reserved("diagnose", targets, campaign.inputs, folder=True, force=force):
        result = _diagnosed(campaign, seed, progress)
        result = _described(result) if describe else result
        if out is not None:
            result.write(out, force)
    return result


def _diagnosed(campaign: Campaign, seed: int, progress: bool | None) -> Diagnosis:
    settings = read_settings(campaign.diagnose, campaign.plant)
    warnings = campaign_warnings(campaign)
    complete = not lacking(campaign, split_campaign(campaign)[0], ())
    with stages("diagnosing", " steps", progress) as say:

        def report(text: str) -> None:
            say(text, "")

        if others := said((n for e in campaign.entries for n in e.left_out), campaign.plant):
            report(others)
        if complete and declares_uncertainty(campaign.plant):
            result = _by_fits(campaign, settings, seed, report)
        else:
            result = _by_holdout(campaign, seed, report)
    warnings += result.verdict.cautions
    return replace(result, verdict=replace(result.verdict, cautions=warnings))


def _described(result: Diagnosis) -> Diagnosis:
    """The same with the generic disturbance in the plant, or why there is none."""
    shape = result.details.shape if result.details else None
    plant = shape.plant if shape and shape.plant else result.plant
    verdict = result.verdict
    cautions = [*verdict.cautions, description_caution(verdict.verdict, verdict.shape)]
    return replace(result, plant=plant, verdict=replace(verdict, cautions=cautions))


def _by_fits(campaign: Campaign, settings: Settings, seed: int, report: Progress) -> Diagnosis:
    found = diagnose_campaign(campaign, settings, seed, report)
    return Diagnosis(
        campaign, found.verdict, found.plant, found.traces, found.noise_floors, (), found
    )


def _by_holdout(campaign: Campaign, seed: int, report: Progress) -> Diagnosis:
    found = diagnose_by_holdout(campaign, seed, report)
    return Diagnosis(
        campaign, found.verdict, found.plant, found.traces, found.noise_floors, found.trials
    )
