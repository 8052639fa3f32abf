"""What a calibration of a known hand amounts to: errors, coverage, labels, as plain data."""

import time
from typing import Any

from benchmarks.calibrating.cases import Case
from hannes.commands.calibrate import calibrate


def outcome(case: Case, seed: int, workers: int | None = None) -> dict[str, Any]:
    """Calibrate a case and compare with the truth; `workers` threads (default: all cores)."""
    begun, spent = time.perf_counter(), time.process_time()
    found = calibrate(case.campaign, seed=seed, workers=workers, progress=False)
    parameters = {}
    for each in found.answers:
        true = case.true[each.name]
        parameters[each.name] = {
            "given": each.given / true - 1.0,
            "error": each.value / true - 1.0,
            "reach": 0.5 * (each.high - each.low) / abs(each.value),
            "covers": bool(each.low <= true <= each.high),
            "textbook_covers": bool(each.textbook[0] <= true <= each.textbook[1]),
            "freedom": min(each.freedom, 1e3),
            "label": each.label,
            "with": list(each.partners),
            "skewed": each.skewed,
        }
    gap = found.fitted_gap
    return {
        "parameters": parameters,
        "starts": found.agreeing,
        "repeats": found.remains.repeats,
        "chance": found.remains.chance,
        "share": found.remains.share,
        "gap": {
            name: [each["as_given"], each["after"], each["floor"]] for name, each in gap.items()
        },
        "seconds": time.perf_counter() - begun,
        "processor_seconds": time.process_time() - spent,
    }
