"""What a calibration of a small campaign says, beside what is so, as plain data."""

import time
from typing import Any

import numpy as np

from benchmarks.few.cases import SPREAD, Case
from benchmarks.few.missing import times_spread
from hannes.commands.calibrate import Calibration, calibrate
from hannes.core.errors import HannesError
from hannes.identification.calibration.identifiability import NORMAL
from hannes.identification.calibration.linearisation import State
from hannes.identification.calibration.rest import APART, SHARE
from hannes.identification.whitening import Whitening
from hannes.plants.hand.plant import RUN_TO_RUN


def outcome(case: Case, seed: int) -> dict[str, Any]:
    """Calibrate a case with default settings and compare with the truth."""
    row: dict[str, Any] = {
        "what": case.kind,
        "stated": case.stated,
        "hidden": next(iter(case.hidden), ""),
        "fault": case.fault,
        "runs": [each.repeats for each in case.protocol.conditions],
    }
    begun = time.process_time()
    try:
        found = calibrate(case.campaign, seed=seed, progress=False)
    except HannesError as error:
        return {**row, "refused": str(error)[:120], "seconds": time.process_time() - begun}
    remains = found.repeatable_residual
    return {
        **row,
        "parameters": _parameters(case, found),
        "repeats": remains.repeats,
        "misleads": found.misleads,
        "ratio": remains.ratio,
        "share": remains.share,
        "chance": remains.chance,
        "looks_like": found.missing.name,
        "deviations": found.missing.deviations,
        "seconds": time.process_time() - begun,
        **({"times_spread": times_spread(case, found.found)} if case.plain else {}),
    }


def _parameters(case: Case, found: Calibration) -> dict[str, dict[str, Any]]:
    known = determined(found.found)
    rows = {}
    for each, could in zip(found.answers, known, strict=True):
        true, half = case.true[each.name], max(0.5 * (each.high - each.low), 1e-300)
        rows[each.name] = {
            "label": each.label,
            "covers": bool(each.low <= true <= each.high),
            "off": abs(each.value - true) / half,
            "error": each.value / true - 1.0,
            "half": half / abs(true),
            "determined": bool(could),
        }
    return rows


def determined(found: State) -> np.ndarray:
    """Which parameters the recordings determine to `limit`, by the model and the true scatter.

    Linearised where the fit ended, with the scatter of hands, joints and runs that there is, and
    the noise that is left in each channel; shape (p,).
    """
    whitenings = [_true(found, place) for place in range(len(found.residuals))]
    scales = [SPREAD.hand / SHARE] * len(found.plan.doubt)
    scales += [SPREAD.finger / APART if "_" in name else SPREAD.hand / SHARE
               for name in found.plan.parts]  # fmt: skip
    sizes = np.array(scales)[:, np.newaxis]
    runs = zip(whitenings, found.columns, found.uncertain_columns, strict=True)
    rows = np.hstack([white(np.vstack([own, sizes * rest])) for white, own, rest in runs])
    prior = np.concatenate([found.scales.prior**2, np.ones(sizes.size)])
    covariance = np.linalg.inv(rows @ rows.T + np.diag(prior))
    count = found.x.size
    half = NORMAL * np.sqrt(np.diag(covariance)[:count]) * found.scales.scale
    values = np.array([found.values[name] for name in found.plan.names])
    return half <= found.plan.limit * np.abs(values)


def _true(found: State, place: int) -> Whitening:
    """Whitening of a run by the noise and the run-to-run scatter that there really is."""
    white, view = found.whitenings[place], found.model.views[place]
    noise = np.ones(view.measured.size)
    for number in np.unique(view.part):
        inside = view.part == number
        left = [
            r[v.part == number] for r, v in zip(found.residuals, found.model.views, strict=True)
        ]
        noise[inside] = max(float(np.sqrt(np.mean(np.concatenate(left) ** 2))), 1e-12)
    usual = [SPREAD.run / max(RUN_TO_RUN.get(name, 2.0 * SPREAD.run), 1e-12)
             for name in found.plan.nuisance]  # fmt: skip
    scales = [*usual, SPREAD.timing / found.plan.start_time] if found.plan.start_time else usual
    return Whitening.of(noise, np.array(scales)[:, np.newaxis] * white.directions)
