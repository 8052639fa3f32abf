"""From cases to figures: what is said of small campaigns, and whether it is so."""

from collections.abc import Sequence
from typing import Any

from benchmarks.calibrating.summary import _held, share
from benchmarks.harness import Row

Cases = Sequence[dict[str, Any]]
COVERED, CALLED, FAR, SOUND, UNSEEN = (0.90, 0.98), 0.70, 0.01, 0.03, 0.02
SAID, LARGE = 0.80, 3.0  # of models that lack so many times the spread of repeats
NONE = {"whole": 0.0, "beyond": 0.0}
HALVES = 3.0  # half-widths from the truth, beyond which a value is plainly wrong


def figures(cases: Cases) -> tuple[list[Row], list[Row]]:
    """Rows by kind of case and by who states what, and what must be shown."""
    rows = [_row(what, stated, cases) for what in ("sound", "missing", "fault")
            for stated in (True, False)]  # fmt: skip
    fitted = [each for each in cases if "parameters" in each]
    sound = [each for each in fitted if each["what"] == "sound"]
    wrong = [each for each in fitted if each["what"] == "missing"]
    named = [p for each in fitted for p in each["parameters"].values()]
    named = [p for p in named if p["label"] == "identified"]
    could = [p for each in sound for p in each["parameters"].values() if p["determined"]]
    shown = []
    if named:
        held = share([p["covers"] for p in named])
        far = share([p["off"] > HALVES for p in named])
        shown.append(_held("intervals of what is called identified hold", held, *COVERED))
        shown.append(_held("identified, beyond three half-widths", far, 0.0, FAR))
    if could:
        called = share([p["label"] == "identified" for p in could])
        shown.append(_held("sound: determined and called identified", called, CALLED))
    if sound:
        said = share([bool(each["misleads"]) for each in sound])
        shown.append(_held("sound: model said to be wrong", said, 0.0, SOUND))
    if wrong:
        unseen = share([each["repeats"] is False for each in wrong])
        shown.append(_held("wrong: residual said not to repeat", unseen, 0.0, UNSEEN))
        for name, what in (("whole", "lacks"), ("beyond", "lacks beyond the machine's values")):
            large = [e for e in wrong if e.get("times_spread", NONE)[name] >= LARGE]
            if large:
                said = share([bool(each["misleads"]) for each in large])
                text = f"{what} {LARGE:g} times the spread of repeats: model said to be wrong"
                shown.append({**_held(text, said, SAID), "cases": len(large)})
    return [row for row in rows if row["cases"]], shown


def _row(what: str, stated: bool, cases: Cases) -> Row:
    some = [each for each in cases if each["what"] == what and each["stated"] == stated]
    fitted = [each for each in some if "parameters" in each]
    named = [p for each in fitted for p in each["parameters"].values()]
    identified = [p for p in named if p["label"] == "identified"]
    return {
        "kind": what,
        "stated": stated,
        "cases": len(some),
        "refused": len(some) - len(fitted),
        "identified": len(identified),
        "of": len(named),
        "held": sum(p["covers"] for p in identified),
        "said wrong": sum(bool(each["misleads"]) for each in fitted),
        "undecided": sum(each["repeats"] is None for each in fitted),
    }
