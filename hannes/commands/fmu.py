"""`hannes fmu`: a hand under an experiment as an FMU for co-simulation (FMI 2.0)."""

import importlib
import shutil
import sys
import tempfile
from pathlib import Path
from typing import Any
from uuid import NAMESPACE_URL, uuid5

from hannes.core.errors import BadInput
from hannes.core.io.atomic_files import atomic_file
from hannes.core.io.optional import library
from hannes.core.io.outputs import reserved
from hannes.plants.hand.recorded_hand import hand_of
from hannes.simulation.experiment.load import load_experiment
from hannes.simulation.experiment.writer import experiment_toml
from hannes.simulation.hand.hand_file import hand_toml

MODULE = "hannes_fmu"  # of the class inside the FMU
SCRIPT = '''"""A Hannes hand as a slave: it runs where Python finds hannes."""

from uuid import UUID

from hannes.plants.hand.fmu_slave import HandSlave
from pythonfmu import Fmi2Slave


class Hannes(HandSlave, Fmi2Slave):
    EXPERIMENT = {experiment!r}
    HAND = {hand!r}
    DURATION, PERIOD = {duration!r}, {period!r}

    def __init__(self, **options):
        super().__init__(**options)
        self.guid = UUID({guid!r})
'''


def fmu(
    experiment: str | Path, out: str | Path = "results/hand.fmu", *, force: bool = False
) -> dict[str, Any]:
    """Write an FMU that makes an experiment tick by tick, with the firmware's sampled controller.

    It runs where Python finds hannes and its libraries; noise is left out. Returns `out` and
    `step` [s], the firmware's period, of which a communication step is a multiple. Raises BadInput
    for an experiment of several variants, for effects of a file, or where pythonfmu is missing.
    """
    builder = library("pythonfmu", "fmu").FmuBuilder
    asked = load_experiment(experiment)
    if len(asked) > 1:
        raise BadInput(f"{experiment}: stands for {len(asked)} simulations; an FMU is one hand")
    hand, planned = asked[0].hand, asked[0].experiment
    texts = {"experiment": experiment_toml(hand, planned), "hand": hand_toml(hand)}
    hand_of(
        texts["hand"], "the hand of an FMU", "an FMU carries only effects that ship with hannes"
    )
    period = float(hand.parameters["controller.period"])
    guid = str(uuid5(NAMESPACE_URL, texts["experiment"] + texts["hand"]))
    with reserved("fmu", [out], [experiment], force=force), tempfile.TemporaryDirectory() as folder:
        script = Path(folder) / f"{MODULE}.py"
        times = {"duration": float(planned.duration), "period": period}
        script.write_text(SCRIPT.format(**texts, **times, guid=guid), encoding="utf-8")
        with atomic_file(out) as target:
            shutil.copy(_built(builder, script, Path(folder) / "built.fmu"), target)
    return {"out": str(out), "step": period}


def _built(builder: Any, script: Path, target: Path) -> Path:
    """Build, and take back what the builder leaves in this process."""
    before = list(sys.path)
    try:
        return Path(builder.build_FMU(script, target))
    finally:
        sys.path[:] = before
        sys.modules.pop(MODULE, None)
        importlib.invalidate_caches()
