"""Table II of a campaign: by condition, measured and simulated, with equation 4 of the paper."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

from hannes.campaigns.campaign import Campaign
from hannes.identification.comparison.run_metrics import NAMES, RunMetrics
from hannes.identification.comparison.spread import Spread, spread
from hannes.identification.grasp_features import UNITS
from hannes.simulation.grasp_metrics import DEFINITIONS, relative_error

EQUATION = "100 (measured - simulated) / measured"


@dataclass(frozen=True)
class Row:
    """One metric of a condition, in SI units; `error` is equation 4 of the means, signed [%]."""

    metric: str
    measured: Spread
    simulated: Spread
    error: float

    @property
    def unit(self) -> str:
        """Unit of measure."""
        return UNITS[self.metric]


@dataclass(frozen=True, eq=False)
class Condition:
    """Runs under one condition: `rows` over all of them, `by_unit` of each unit alone."""

    name: str
    runs: tuple[RunMetrics, ...]
    rows: tuple[Row, ...]
    by_unit: dict[str, tuple[Row, ...]]

    @property
    def units(self) -> tuple[str, ...]:
        """Names of the units, in the order of the campaign."""
        return tuple(self.by_unit)

    @property
    def repeated(self) -> bool:
        """Whether some unit has two runs of it."""
        return len(self.runs) > len(self.by_unit)

    @property
    def left_out(self) -> list[tuple[str, str, tuple[str, ...]]]:
        """Metric, reason, and the recordings that it holds for."""
        found: dict[tuple[str, str], list[str]] = {}
        for each in self.runs:
            for name, why in each.left_out.items():
                found.setdefault((name, why), []).append(each.run.entry.name)
        return [(name, why, tuple(names)) for (name, why), names in found.items()]


@dataclass(frozen=True, eq=False, repr=False)
class Compared:
    """The comparison of a campaign; `cautions` are about its recordings."""

    campaign: Campaign
    conditions: tuple[Condition, ...]
    cautions: tuple[str, ...] = ()

    @property
    def largest(self) -> tuple[Condition, Row] | None:
        """Condition and metric with the largest relative error; None where there is none."""
        found = [(each, row) for each in self.conditions for row in each.rows]
        return max(found, key=lambda pair: abs(pair[1].error), default=None)

    @property
    def metrics(self) -> list[str]:
        """Names of all metrics that were formed."""
        formed = {row.metric for each in self.conditions for row in each.rows}
        return [name for name in NAMES if name in formed]

    @property
    def notes(self) -> list[str]:
        """What a reader must know before believing an error."""
        single = [each.name for each in self.conditions if not each.repeated]
        notes = []
        if len(single) == len(self.conditions):
            notes.append(
                "No condition has repeats: how far runs differ by themselves is unknown, and an "
                "error may be chance"
            )
        elif single:
            notes.append(f"No repeats of {', '.join(single)}: there an error may be chance")
        touches = {each.run.touch for condition in self.conditions for each in condition.runs}
        if "sensor" in touches:
            notes.append(
                "Where no total force was recorded, contact and F_max are a dynamometer's "
                "(sensor_N), measured and simulated"
            )
        if all(each.recording.source == "simulated" for each in self.campaign.entries):
            notes.append("These recordings are simulated, too")
        notes.append(
            "Nothing is fitted here. Where the hand's values were fitted to these recordings, "
            "agreement is no validation"
        )
        return notes

    def plain(self) -> dict[str, Any]:
        """Everything as plain values, as compare.json has it."""
        return {
            "title": self.campaign.title,
            "equation": EQUATION,
            "definitions": {name: DEFINITIONS[name] for name in self.metrics},
            "conditions": [_plain(each) for each in self.conditions],
            "recordings": [_plain_run(run) for each in self.conditions for run in each.runs],
            "notes": self.notes,
            "cautions": list(self.cautions),
        }


def conditions(runs: Sequence[RunMetrics]) -> tuple[Condition, ...]:
    """Group runs by condition, in the order of the campaign."""
    names = dict.fromkeys(each.run.entry.condition for each in runs)
    return tuple(
        _condition(name, tuple(each for each in runs if each.run.entry.condition == name))
        for name in names
    )


def _condition(name: str, runs: tuple[RunMetrics, ...]) -> Condition:
    units = {
        unit: tuple(each for each in runs if each.run.unit == unit)
        for unit in dict.fromkeys(each.run.unit for each in runs)
    }
    return Condition(name, runs, _rows(units), {u: _rows({u: own}) for u, own in units.items()})


def _rows(units: dict[str, tuple[RunMetrics, ...]]) -> tuple[Row, ...]:
    return tuple(_row(name, units) for name in NAMES if _holders(name, units))


def _holders(name: str, units: dict[str, tuple[RunMetrics, ...]]) -> dict[str, list[RunMetrics]]:
    found = {u: [each for each in runs if name in each.pairs] for u, runs in units.items()}
    return {unit: runs for unit, runs in found.items() if runs}


def _row(name: str, units: dict[str, tuple[RunMetrics, ...]]) -> Row:
    held = _holders(name, units)
    measured = spread({u: [e.pairs[name].measured for e in runs] for u, runs in held.items()})
    simulated = spread({u: [e.pairs[name].simulated for e in runs] for u, runs in held.items()})
    return Row(name, measured, simulated, relative_error(measured.mean, simulated.mean))


def _plain(condition: Condition) -> dict[str, Any]:
    return {
        "condition": condition.name,
        "recordings": [each.run.entry.name for each in condition.runs],
        "units": [unit for unit in condition.units if unit],
        "repeats": condition.repeated,
        "metrics": _plain_rows(condition.rows),
        "by_unit": {unit: _plain_rows(rows) for unit, rows in condition.by_unit.items() if unit},
        "left_out": [
            {"metric": name, "reason": why, "recordings": list(names)}
            for name, why, names in condition.left_out
        ],
    }


def _plain_rows(rows: Sequence[Row]) -> dict[str, Any]:
    return {
        row.metric: {
            "unit": row.unit,
            "measured": asdict(row.measured),
            "simulated": asdict(row.simulated),
            "error_percent": row.error,
        }
        for row in rows
    }


def _plain_run(each: RunMetrics) -> dict[str, Any]:
    entry = each.run.entry
    return {
        "file": entry.name,
        "condition": entry.condition,
        "unit": entry.unit or None,
        "command_starts_s": each.run.shift,
        "contact_by": each.run.touch or None,
        "metrics": {
            name: {
                "unit": UNITS[name],
                "measured": pair.measured,
                "simulated": pair.simulated,
                "error_percent": pair.error,
            }
            for name, pair in each.pairs.items()
        },
        "left_out": each.left_out,
    }
