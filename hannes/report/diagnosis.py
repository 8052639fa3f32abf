"""The page of a diagnosis.

The sentence; what the effect is and where it sits; before and after; where it disagreed; rivals.
"""

from typing import TYPE_CHECKING, Any

import numpy as np

from hannes.identification.effect_words import effect_words
from hannes.identification.size_words import readable_unit, size_text
from hannes.identification.verdict import (
    indistinguishable,
    refitted_text,
)
from hannes.report.effect_section import explained_effects, marked_schematic
from hannes.report.figure_diagnosis import figures
from hannes.report.figure_shape import shape_figures
from hannes.report.formats import decimals, number, signed
from hannes.report.page import render
from hannes.report.residual_map import constant_part, residual_map
from hannes.report.table import Table

if TYPE_CHECKING:
    from hannes.report.diagnosed import Diagnosis

STAGES = ("as_given", "before", "after")
WHERE, RANKING = "diagnosis-where", "diagnosis-ranking"  # names of figures
MOST_MOVED = 12  # rows of the table of the baseline
MANY = 24  # recordings, beyond which a list of them is not readable


def page(diagnosis: "Diagnosis") -> str:
    """Return report.html: self-contained, no script, no network."""
    verdict = diagnosis.verdict
    drawn = figures(diagnosis)
    return render(
        "diagnosis.html.j2",
        {
            "title": diagnosis.campaign.title,
            "verdict": verdict,
            "effects": explained_effects(diagnosis),
            "schematic": marked_schematic(diagnosis),
            "figures": [each for each in drawn if each.name not in (WHERE, RANKING)],
            "worst": [each for each in drawn if each.name == WHERE],
            "rivals": [each for each in drawn if each.name == RANKING],
            "map": residual_map(diagnosis),
            "shape": shape_figures(verdict.shape),
            "gaps": _gaps(diagnosis),
            "sizes": _sizes(diagnosis),
            "each_explains": _each_explains(diagnosis),
            "baseline": _baseline(diagnosis),
            "tried": _tried(diagnosis),
            "confusability": _confusability(diagnosis),
            "recordings": _recordings(diagnosis),
        },
    )


def _gaps(diagnosis: "Diagnosis") -> Table:
    rows = []
    for name, gap in diagnosis.verdict.gap.items():
        unit, factor = readable_unit(gap["unit"])
        shares = [number(gap[f"{key}_percent"]) for key in STAGES]
        sizes = [
            f"{number(factor * gap[key])} ({share} %)"
            for key, share in zip(STAGES, shares, strict=True)
        ]
        label = name if unit == "1" else f"{name} [{unit}]"
        floor = number(factor * gap["floor"], 2)
        rows.append((label, *sizes, floor, _meaning(diagnosis, name)))
    columns = ("RMS gap", "As given", "Baseline refitted", "After", "Noise floor", "What is left")
    verdict = diagnosis.verdict
    note = (
        f"On {verdict.gap_on}. In brackets: relative to the recorded signal, "
        f"100 |simulated − measured| / |measured|. "
        f"The noise floor is {verdict.floor_from}."
    )
    if not verdict.refit_taken:
        note += " Here the baseline stands as given; a caution says where refitting was not taken."
    if not verdict.effects:
        given = verdict.verdict == "no_gap" or not verdict.refit_taken
        note += f" No effect was added: After is the machine {'as given' if given else 'refitted'}."
    return Table("gaps", "The gap before and after", columns, tuple(rows), note)


def _meaning(diagnosis: "Diagnosis", name: str) -> str:
    """What the gap that is left of a channel means."""
    gap = diagnosis.verdict.gap[name]
    times = gap["after"] / gap["floor"]
    if times <= 1.0:
        return "below the noise floor: no more than repeats differ by"
    if offset := constant_part(diagnosis, name):
        unit, factor = readable_unit(gap["unit"])
        size = number(factor * offset) + (f" {unit}" if unit != "1" else "")
        part = "nearly all of it" if abs(offset) > 0.9 * gap["after"] else "most of it"
        return f"{part} a constant, {size}: check that sensor's zero"
    return f"{number(times, 2)} times the noise floor"


def _sizes(diagnosis: "Diagnosis") -> Table:
    parameters = diagnosis.verdict.parameters
    vague = indistinguishable(parameters)
    rows = [
        (name, size_text(p), "no" if name in vague else "yes") for name, p in parameters.items()
    ]
    columns = ("Parameter", "Value (95 % interval)", "Distinguishable from no effect")
    note = "The interval contains the value at which it does nothing."
    return Table("sizes", "Size of the effect", columns, tuple(rows), note if vague else "")


def _each_explains(diagnosis: "Diagnosis") -> Table:
    """What each of several effects explains that the others do not."""
    verdict = diagnosis.verdict
    names = [name for name in verdict.gap if verdict.each_explains]
    rows = []
    for effect, found in verdict.each_explains.items():
        factors = [readable_unit(verdict.gap[name]["unit"])[1] for name in names]
        gaps = [number(factor * found["without"][name])
                for name, factor in zip(names, factors, strict=True)]  # fmt: skip
        rows.append((effect_words(effect), f"{number(100.0 * found['explains'], 2)} %", *gaps))
    units = [readable_unit(verdict.gap[name]["unit"])[0] for name in names]
    channels = [name if unit == "1" else f"{name} [{unit}]"
                for name, unit in zip(names, units, strict=True)]  # fmt: skip
    note = (
        f"On {verdict.gap_on}: each effect is left out in turn, all else following. The share of "
        "the reducible gap that comes back, and the RMS gap then. What another one that is named "
        "can do as well does not come back."
    )
    columns = ("Left out", "Gap that comes back", *channels)
    return Table("each-explains", "What each effect explains", columns, tuple(rows), note)


def _baseline(diagnosis: "Diagnosis") -> Table:
    """What of the machine itself was off; hidden effects bend these values."""
    verdict = diagnosis.verdict
    found = verdict.baseline or {"intervals_from": "", "parameters": []}
    shown = found["parameters"][:MOST_MOVED]
    rows = [(*refitted_text(row), _interval(row), signed(row["moved"])) for row in shown]
    note = (
        f"Of {len(found['parameters'])} uncertain parameters, those that moved most; verdict.json "
        f"has all. Intervals are from {found['intervals_from']}. A deviation is a standard "
        "deviation of the prior."
    )
    if verdict.verdict not in ("recalibrated", "no_gap"):
        note += " What is missing may have moved these values: no new effect is in this fit."
    columns = ("Parameter", "Nominal", "Refitted", "95 % interval", "Deviations")
    title = "What was off" if verdict.verdict == "recalibrated" else "The baseline, refitted"
    return Table("baseline", title, columns, tuple(rows), note)


def _interval(row: dict[str, Any]) -> str:
    """Its ends, with two digits of its width."""
    _, factor = readable_unit(row["unit"])
    low, high = factor * row["low"], factor * row["high"]
    width = max(high - low, 1e-9 * abs(low), 1e-300)
    digits = int(np.ceil(np.log10(max(abs(low), abs(high), width) / width))) + 2
    return f"{number(low, digits)} to {number(high, digits)}"


def _tried(diagnosis: "Diagnosis") -> Table:
    candidates = {row["effect"]: row for row in diagnosis.verdict.candidates}
    rows = []
    unfit = [each["effect"] for each in diagnosis.verdict.tried if not each["applicable"]]
    evidence, level = "Size / its deviation", "Each tested at a false-alarm rate of"
    if diagnosis.details is not None:
        evidence = "√ of Δχ²"
        level = "A machine that lacks nothing should get a name with a probability of at most"
    for attempt in diagnosis.verdict.tried:
        if attempt["effect"] in unfit:
            continue
        row = candidates.get(attempt["effect"])
        about = "" if row is None or row.get("refitted", True) else "≈ "
        share = f"{about}{decimals(round(100.0 * row['gain_select']), 0)} %" if row else "–"
        sigma = f"{about}{number(row['evidence'], 2)}" if row else "–"
        confusable = ", ".join(_confusable(diagnosis, row)) if row else ""
        least = _least(diagnosis, attempt["effect"])
        rows.append((attempt["effect"], share, sigma, least, confusable or "–", attempt["why"]))
    size = "Minimum detectable size"
    columns = ("Effect", "Explains", evidence, size, "Confusable with", "Outcome")
    note = (
        "Misfit: squared residuals over their variance, summed (chi-squared). "
        f"{level} {diagnosis.verdict.alpha:g}. Minimum detectable size: "
        "at 80 % power, by a linear fit; “none” where it lies beyond the physical bounds, "
        "a number without a unit is a ratio."
    )
    if diagnosis.details is not None:
        note += " ≈: by a linear estimate; not fitted, as others promised more."
    if unfit:
        note += f" Not tried: {', '.join(unfit)}; verdict.json says why."
    return Table("tried", "What was tried", columns, tuple(rows), note)


def _confusable(diagnosis: "Diagnosis", row: dict[str, Any]) -> list[str]:
    """Effects that are hardly separated from one: alike in shape, or one of the same verdict."""
    verdict, name = diagnosis.verdict, row["effect"]
    rivals = verdict.effects if verdict.verdict == "one_of" and name in verdict.effects else []
    return [each for each in dict.fromkeys((*row["confusable_with"], *rivals)) if each != name]


def _least(diagnosis: "Diagnosis", effect: str) -> str:
    """The minimum detectable size of each amplitude of an effect."""
    found = (diagnosis.verdict.smallest_detectable or {}).get(effect, {})
    shown = [
        f"{name} none" if each["value"] is None else f"{name} {_sized(each)}"
        for name, each in found.items()
    ]  # fmt: skip
    return ", ".join(shown) or "–"


def _sized(amplitude: dict[str, Any]) -> str:
    """An amplitude in the unit in which the sentence has it."""
    unit, factor = readable_unit(amplitude["unit"])
    shown = number(factor * amplitude["value"], 2)
    return shown if unit == "1" else f"{shown} {unit}"


def _confusability(diagnosis: "Diagnosis") -> Table:
    measured = diagnosis.verdict.confusability or {"effects": [], "cosines": []}
    names = [effect_words(name) for name in measured["effects"]]
    rows = tuple(
        (name, *(decimals(cosine, 2) for cosine in cosines))
        for name, cosines in zip(names, measured["cosines"], strict=True)
    )
    note = (
        "Cosine similarity of the signatures of two effects in these recordings, beyond what the "
        "machine's own parameters can do: 0 is nothing in common, 1 the same."
    )
    return Table("confusability", "Confusable effects", ("", *names), rows, note)


def _recordings(diagnosis: "Diagnosis") -> Table:
    roles = diagnosis.verdict.recordings
    rows = tuple((role, _listed(names)) for role, names in roles.items())
    note = (
        "Parameters are fitted to those in role fit, effects are chosen on those in role select; "
        "those in role show are for the test alone."
    )
    return Table("recordings", "Recordings by role", ("Role", "Recordings"), rows, note)


def _listed(names: list[str]) -> str:
    """All names, or the first and last of many."""
    if len(names) <= MANY:
        return ", ".join(names) or "none"
    return f"{len(names)}: {', '.join(names[:2])}, … {names[-1]}; all in verdict.json"
