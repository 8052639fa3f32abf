"""A log through its mapping into recordings, and the mapping changed as findings say."""

import json
import tomllib
from collections.abc import Iterable
from copy import deepcopy
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.intake.bases import Base
from benchmarks.intake.log import Log
from hannes.campaigns.convert import Converted, convert

PLANTS = {"hand": "hand", "axis": "axis", "servo": "benchmarks.intake.servo_plant:Servo"}
LEAVE_OUT = "leave out "
Mapping = dict[str, Any]


def sound_mapping(run: Base, log: Log) -> Mapping:
    """What the lab believes of its log: columns, units, what was done."""
    units = {"hand": "rad", "axis": "m", "servo": "rad"}
    known = {"current": "A", "drive": "V", "duty": "1", "supply": "V", "force": "N", "sensor": "N"}
    made: Mapping = {"plant": PLANTS[log.machine], "time": {"column": "time", "unit": "s"}}
    if run.experiment:
        made["experiment"] = "experiment.toml"
    made["channels"] = {
        name: {"column": name, "unit": known.get(name, units[log.machine])}
        for name in log.columns
        if name != "time"
    }
    return made


def recordings(run: Base, log: Log, mapping: Mapping, folder: Path) -> list[Converted]:
    """Write the log and its mapping, convert; BadInput as `hannes convert` refuses."""
    np.savez(folder / "log.npz", **log.columns)  # type: ignore[arg-type]
    (folder / "experiment.toml").write_text(run.experiment, encoding="utf-8")
    (folder / "mapping.toml").write_text(toml(mapping), encoding="utf-8")
    return convert([folder / "log.npz"], folder / "mapping.toml", trust=True)


def toml(mapping: Mapping) -> str:
    """A mapping as TOML: its values are written as JSON writes them."""
    lines = [f"{key} = {json.dumps(x)}" for key, x in mapping.items() if not isinstance(x, dict)]
    for name in ("time", "text", "align"):
        if name in mapping:
            lines += [f"[{name}]", *(f"{k} = {json.dumps(x)}" for k, x in mapping[name].items())]
    for name, rule in mapping["channels"].items():
        lines += [f"[channels.{name}]", *(f"{k} = {json.dumps(x)}" for k, x in rule.items())]
    return "\n".join(lines) + "\n"


def mended(mapping: Mapping, mends: Iterable[str]) -> Mapping | None:
    """The mapping changed as findings say; None where they say to leave the file out."""
    made = deepcopy(mapping)
    for each in mends:
        if each.startswith(LEAVE_OUT):
            what = each.removeprefix(LEAVE_OUT)
            if not what.startswith("channels."):
                return None
            made["channels"].pop(what.removeprefix("channels."), None)
        else:
            _merge(made, tomllib.loads(each))
    return made if made["channels"] else None


def _merge(into: Mapping, more: Mapping) -> None:
    for key, value in more.items():
        if isinstance(value, dict):
            _merge(into.setdefault(key, {}), value)
        elif isinstance(value, list) and key in into:  # of several findings
            into[key] = into[key] + [each for each in value if each not in into[key]]
        else:
            into[key] = value
            if key == "sampling":  # a clock is a column or a rate
                for other in ("column", "unit", "from_zero", "order", "wrap"):
                    into.pop(other, None)
