"""The panel's page: controls, traces and libraries in one file."""

import json
from collections.abc import Sequence
from pathlib import Path

from hannes.bench.panel.drive import Range
from hannes.report.page import environment
from hannes.report.viewer.page import vendor

HERE = Path(__file__).parent


def panel_page(
    port: str, experiments: Sequence[str], within: Range, recognises: bool, notice: str = ""
) -> str:
    """The page for a hand on `port`; `recognises`: there is a trained model; `notice` about it."""
    known = {"opened": within.opened, "closed": within.closed, "recognises": recognises}
    return (
        environment()
        .get_template("panel.html.j2")
        .render(
            port=port,
            experiments=experiments,
            within=within,
            recognises=recognises,
            notice=notice,
            known=json.dumps(known),
            vendor=vendor(),
            style=(HERE / "panel.css").read_text(encoding="utf-8"),
            script=(HERE / "panel.js").read_text(encoding="utf-8"),
        )
    )
