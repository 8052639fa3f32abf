"""What the page says of a diagnosis: its verdict, or why there is none and how to get one."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from hannes.core.errors import HannesError
from hannes.identification.verdict import Verdict, indistinguishable
from hannes.report.paper.tables import gap_table
from hannes.report.table import Table


@dataclass(frozen=True)
class Finding:
    """`verdict` is the content of verdict.json; without it `missing` says what to do.

    `coming`: who completes it, where it is still being computed.
    """

    name: str
    title: str
    about: str
    verdict: Mapping[str, Any] | None = None
    missing: str = ""
    coming: str = ""
    link: str = ""
    tables: tuple[Table, ...] = ()

    @property
    def sentence(self) -> str:
        """The verdict in plain words."""
        return Verdict(**self.verdict).sentence if self.verdict else ""

    @property
    def sizes(self) -> list[str]:
        """Each fitted value with its interval and unit."""
        found = (self.verdict or {}).get("parameters", {})
        vague = indistinguishable(found)
        return [
            f"{name} = {each['value']:.4g} {each['unit']} ({each['low']:.4g} to {each['high']:.4g})"
            + (
                f": not distinguishable from no effect, the interval contains {each['off']:g}"
                if name in vague
                else ""
            )
            for name, each in found.items()
        ]

    @property
    def all_tables(self) -> tuple[Table, ...]:
        """Own tables, then the gaps of the verdict."""
        own = (gap_table(f"{self.name}-gap", self.verdict),) if self.verdict else ()
        return (*self.tables, *(each for each in own if each.rows))


ABOUT = {
    "emps": (
        "Real machine: EMPS",
        "A motor-driven axis recorded by other researchers at 1 kHz, with its exact controller: "
        "the one real machine on this page. One file is fitted, the other is the test.",
    ),
    "slack": (
        "Hidden slack",
        "Free closures written by a second, independent implementation of the hand, in which the "
        "leader wire was left slack. The diagnosis is not given that. No real hand is involved.",
    ),
    "recognition": (
        "Rigid or soft",
        "A classifier trained on simulated grasps alone, on recordings of ten virtual objects that "
        "the second implementation of the hand grasped. These hands have other parameters, leader "
        "slack and load-dependent gear friction, of sizes within the training data.",
    ),
}
RUN = {"recognition": "not scored in this run; `make run` records the objects and scores them"}


def coming(name: str) -> Finding:
    """A finding that is still being computed."""
    title, about = ABOUT[name]
    return Finding(name, title, about, coming="the command that wrote this page completes it")


def findings(given: Mapping[str, Any] | None) -> list[Finding]:
    """Return all findings in order; `given` maps their names to a Finding, a verdict, or a reason.

    A reason is an error such as MissingRecording, or a text.
    """
    return [_finding(name, (given or {}).get(name)) for name in ABOUT]


def finding(
    name: str, verdict: Mapping[str, Any], *, link: str = "", tables: tuple[Table, ...] = ()
) -> Finding:
    """Return the finding `name` ("emps" or "slack") with the content of its verdict.json."""
    title, about = ABOUT[name]
    return Finding(name, title, about, verdict=verdict, link=link, tables=tables)


def _finding(name: str, given: Any) -> Finding:
    title, about = ABOUT[name]
    if isinstance(given, Finding):
        return given
    if isinstance(given, Mapping):
        return finding(name, given)
    if isinstance(given, HannesError | str):
        return Finding(name, title, about, missing=str(given))
    command = RUN.get(name, f"not diagnosed in this run; run: hannes diagnose {name}.toml")
    return Finding(name, title, about, missing=command)
