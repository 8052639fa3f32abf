"""Fit a plant's parameters to recordings, with honest intervals and what the data cannot show.

How: hannes/identification/calibration/__init__.py. Recordings in roles fit and select are fitted,
those in role show are only predicted.
"""

import os
from dataclasses import replace
from pathlib import Path

import numpy as np

from hannes.campaigns.campaign import Campaign
from hannes.campaigns.campaign_file import read_campaign
from hannes.campaigns.undeclared import said
from hannes.core.errors import BadInput
from hannes.core.io import atomic_files
from hannes.core.io.outputs import reserved
from hannes.core.io.progress import stages
from hannes.identification.binned_run import BLOCKS_PER_PARAMETER, View
from hannes.identification.calibration.data_check import DataIssues, data_issues
from hannes.identification.calibration.far_value import far_values, without_far
from hannes.identification.calibration.heldout_prediction import prediction
from hannes.identification.calibration.identifiability import answers
from hannes.identification.calibration.intervals import spread
from hannes.identification.calibration.linearisation import State
from hannes.identification.calibration.missing_effect import MissingEffect, missing_effect
from hannes.identification.calibration.observed_controller import as_recorded
from hannes.identification.calibration.profile_likelihood import sides
from hannes.identification.calibration.repeat_noise import noise_floors, sample_noise_floors
from hannes.identification.calibration.repeatable_residual import repeatable_residual
from hannes.identification.calibration.result import Fit
from hannes.identification.calibration.search import Progress, Search
from hannes.identification.calibration.settings import Plan, read_plan
from hannes.identification.calibration.simulator import Model
from hannes.plants.plant_file import plant_toml

Gap = dict[str, dict[str, float]]


class Calibration(Fit):
    """The result of `calibrate`: see identification/calibration/result.py; it can be written."""

    def write(self, folder: str | Path, force: bool = False) -> Path:
        """Write calibration.json, hand.toml, report.html into `folder`, whole or not at all.

        `force`: results of another command there are replaced, too.
        """
        from hannes.report.calibration import page

        with atomic_files.atomic_folder(folder, "calibrate", force) as temporary:
            (temporary / "calibration.json").write_text(self.json(), encoding="utf-8")
            (temporary / "hand.toml").write_text(self.toml(folder), encoding="utf-8")
            (temporary / "report.html").write_text(page(self), encoding="utf-8")
        return Path(folder)

    def toml(self, folder: str | Path | None = None) -> str:
        """Text of the hand.toml of the plant at the fitted values, to lie in `folder`."""
        return plant_toml(self.plant, self.campaign.shipped, self.campaign.base, folder)


def calibrate(
    campaign: Campaign | str | Path,
    *,
    out: str | Path | None = None,
    seed: int = 0,
    plan: Plan | None = None,
    workers: int | None = None,
    progress: bool | None = None,
    force: bool = False,
    trust: bool = False,
) -> Calibration:
    """Calibrate by a campaign, or the TOML file of one; writes to `out` where given.

    `plan` replaces the campaign's table [calibrate]. `workers` threads simulate (default: one for
    each processor), which changes no result. `force`: results of another command in `out` are
    replaced, too. `trust`: Python that the TOML file names may run. `progress`: True: a bar on
    standard error, or where that is no terminal one line a stage; by default the bar alone.
    Interrupted (Ctrl-C), it returns the best so far.
    Raises BadInput for what cannot be used, which includes what the data check finds and the plan
    does not accept; ComputationFailed where no simulation succeeds or the fit does not converge.
    """
    if not isinstance(campaign, Campaign):
        campaign = read_campaign(campaign, seed, trust=trust)
    targets = [out] if out is not None else []
    with reserved("calibrate", targets, campaign.inputs, folder=True, force=force):
        result = _calibrated(campaign, seed, plan, workers, progress)
        if out is not None:
            result.write(out, force)
    return result


def _calibrated(
    campaign: Campaign, seed: int, plan: Plan | None, workers: int | None, progress: bool | None
) -> Calibration:
    campaign, controller = as_recorded(campaign)
    entries = campaign.of("fit", "select") or campaign.entries
    recorded = {name for entry in entries for name in entry.recording.names}
    plan = plan or read_plan(campaign.calibrate, campaign.plant, recorded, seed)
    parts = plan.rest.parts(campaign.plant, entries)
    plan = replace(plan, parts=parts, controller=controller)
    issues = data_issues(campaign, plan.accept)
    views = [View(entry, campaign.plant, plan.channels, plan.features) for entry in entries]
    _require_enough(plan, views)
    level, how = noise_floors(views)
    workers = workers or os.cpu_count() or 1
    with stages("calibrating", " runs", progress) as say:

        def report(text: str, rms: float) -> None:
            say(text, f"RMS {rms:.4g}")

        if others := said((n for e in campaign.entries for n in e.left_out), campaign.plant):
            say(others, "")
        found = Search(Model(campaign.plant, views), plan, level, workers, report).run()
        return _result(campaign, found, issues, workers, how, seed, report)


def _result(
    campaign: Campaign,
    found: State,
    issues: DataIssues,
    workers: int,
    how: str,
    seed: int,
    progress: Progress,
) -> Calibration:
    width, noise = spread(found), sample_noise_floors(found.model.views)
    halves, held_out, fitted = np.tile(width.reach, (2, 1)), {}, {}
    missing = MissingEffect()

    def gap(*roles: str) -> Gap:
        made = prediction(found, campaign.of(*roles))
        return {name: {**each, "floor": noise[name]} for name, each in made.items()}

    try:
        progress("intervals", found.rms)
        halves = sides(found, width, workers)
        apart = bool(campaign.of("fit", "select"))
        held_out = gap("show") if apart else {}
        fitted = gap("fit", "select") if apart else gap("show")
        progress("effects that may be missing", found.rms)
        missing = missing_effect(found, list(campaign.effects.values()))
    except KeyboardInterrupt:  # then intervals are as wide above as below, and gaps not known
        found = replace(found, interrupted=True)
    repeated = repeatable_residual(found)
    wrong = repeated.misleads or missing.likely
    lack_of_fit = "the model does not fit: see what remains" if wrong else ""
    made = answers(found, width, halves, lack_of_fit)
    far = far_values(found.plan, made)
    return Calibration(
        campaign,
        issues,
        found,
        width,
        tuple(without_far(made, far)),
        repeated,
        missing,
        far,
        held_out,
        fitted,
        how,
        seed,
    )


def _require_enough(plan: Plan, views: list[View]) -> None:
    """Raise BadInput where the recordings determine fewer parameters than are asked for."""
    if not any(view.measured.size for view in views):
        raise BadInput("no recording has a channel or a feature that [calibrate] asks for")
    starts = 1 if plan.start_time else 0
    max_parameters = sum(max(0, view.max_parameters - starts) for view in views)
    if plan.named and len(plan.names) > max_parameters:
        block = views[0].block_length
        raise BadInput(
            f"{len(plan.names)} parameters are more than {len(views)} recordings of this length "
            f"can determine ({max_parameters}: {BLOCKS_PER_PARAMETER} blocks of {block:g} s or one "
            "feature for each, less one for every start); record more runs, or name fewer "
            "parameters"
        )
