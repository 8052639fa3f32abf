"""Figures of the study, and the bounds that they must keep."""

from collections.abc import Sequence
from typing import Any

from benchmarks.harness import Row, must_show

Rows = Sequence[dict[str, Any]]

FOUND = {"gross": 0.99, "middling": 0.90}
NAMED, MENDED, FALSE, EACH_KIND = 0.95, 0.90, 0.01, 0.9


def figures(done: Rows) -> tuple[list[Row], list[Row]]:
    """A row a kind, and the bounds over all of them."""
    faults = [each for each in done if each.get("strength") in ("gross", "middling", "small")]
    shown = [each for each in faults if not each["hidden"]]
    names = sorted({each["fault"] for each in faults})
    rows = [_of_kind(name, [each for each in faults if each["fault"] == name]) for name in names]
    bounds = [_found(shown, strength, bound) for strength, bound in FOUND.items()]
    heard = [each for each in shown if each["found"] and each["strength"] != "small"]
    bounds.append(_share("right kind named", heard, "named", NAMED))
    bounds += _mend_bounds(names, heard)
    sound = [each for each in done if each["kind"] == "sound"]
    if sound:
        false = sum(bool(each["faults"]) for each in sound) / len(sound)
        bounds.append(
            must_show(f"of {len(sound)} sound logs, called faulty", false, FALSE, false <= FALSE)
        )
        warned = sum(bool(each["warnings"]) for each in sound) / len(sound)
        rows.append({"kind": "sound logs: a warning", "cases": len(sound), "share": warned})
    return [{**_EMPTY, **row} for row in rows], bounds


_EMPTY: Row = dict.fromkeys(
    ("kind", "gross", "found", "middling", "found_", "small", "found__", "named", "mended",
     "hidden", "why", "cases", "share"), "")  # fmt: skip


def _of_kind(name: str, cases: Rows) -> Row:
    shown = [each for each in cases if not each["hidden"]]
    row: Row = {"kind": name}
    for strength, column in (("gross", "found"), ("middling", "found_"), ("small", "found__")):
        some = [each for each in shown if each["strength"] == strength]
        row[strength] = len(some)
        row[column] = _ratio(some, "found") if some else ""
    heard = [each for each in shown if each["found"] and each["strength"] != "small"]
    row["named"] = _ratio(heard, "named") if heard else ""
    row["mended"] = _ratio(heard, "mended") if heard else ""
    hidden = [each for each in cases if each["hidden"]]
    row["hidden"] = len(hidden)
    row["why"] = "; ".join(sorted({each["hidden"] for each in hidden}))[:60]
    return row


def _ratio(cases: Rows, key: str) -> float:
    return sum(bool(each.get(key)) for each in cases) / len(cases)


def _found(shown: Rows, strength: str, bound: float) -> Row:
    some = [each for each in shown if each["strength"] == strength]
    return _share(f"{strength} faults found, of {len(some)}", some, "found", bound)


def _share(name: str, cases: Rows, key: str, bound: float) -> Row:
    value = _ratio(cases, key) if cases else 1.0
    return must_show(name, value, bound, value >= bound)


def _mend_bounds(names: Sequence[str], heard: Rows) -> list[Row]:
    """Kinds whose key restores the log, or leaves the bad samples out, in nine of ten cases."""
    bounds = []
    for restorable, what in ((True, "restored by the key named"), (False, "left out")):
        kinds = {each["fault"] for each in heard if each.get("restorable") is restorable}
        good = [
            name
            for name in kinds
            if _ratio([each for each in heard if each["fault"] == name], "mended") >= EACH_KIND
        ]
        value = len(good) / len(kinds) if kinds else 1.0
        name = f"kinds {what}, of {len(kinds)}"
        bounds.append(must_show(name, value, MENDED, value >= MENDED))
    return bounds
