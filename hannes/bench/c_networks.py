"""Networks of the stiffness by traces as C constants, and the sizes that their code goes by."""

from dataclasses import dataclass

import numpy as np

from hannes.bench.c_tables import array, number, short
from hannes.dataset.empty_closure import mean_size
from hannes.recognition import pressed
from hannes.recognition.pressed import PressedStiffness
from hannes.simulation.experiment.load import load_experiment

TABLES = ("mix", "hand_mix", "first", "second", "last")


@dataclass(frozen=True)
class CNetworks:
    """Constants as text, empty without networks, and their bytes."""

    text: str
    table_bytes: int


def networks(known: PressedStiffness | None, sampling: float) -> CNetworks:
    """The networks as C arrays, none where the traces cannot be had at `sampling` [Hz]."""
    if known is None or not pressed.bin_size(sampling):
        return CNetworks("", 0)
    centres = [name for name in ("centre", "hand_centre") if getattr(known, name).size]
    tables = [name for name in TABLES if getattr(known, name).size]
    parts = [
        array("double", f"hannes_{name}", map(number, getattr(known, name))) for name in centres
    ]
    parts += [
        array("float", f"hannes_{name}", map(short, getattr(known, name).ravel()))
        for name in tables
    ]
    hands = _hands(known) if known.hand_mix.size else {}
    parts += [array("double", f"hannes_{name}", map(number, each)) for name, each in hands.items()]
    size = sum(8 * getattr(known, name).size for name in centres)
    size += sum(4 * getattr(known, name).size for name in tables)
    size += sum(8 * each.size for each in hands.values())
    return CNetworks("\n".join(parts) + "\n", size)


def _hands(known: PressedStiffness) -> dict[str, np.ndarray]:
    """What else a closure on nothing needs: how far hands are known, and its command [s], [rad]."""
    times, angles = _empty_command()
    return {"hand_reach": known.reach[1:], "empty_times": times, "empty_angles": angles}


def _empty_command() -> np.ndarray:
    """Times [s] and angles [rad] of the corners of the command of `empty-closure`, (2, corners)."""
    return load_experiment("empty-closure")[0].experiment.reference.knots


def network_sizes(known: PressedStiffness | None, sampling: float) -> dict[str, str]:
    """Whole numbers of the C file about them."""
    size = pressed.bin_size(sampling)
    if known is None or not size:
        return {"NETS": "0", "BINS": "1", "HAND": "0"}
    values = {
        "NETS": known.first.shape[0],
        "POINTS": known.mix.shape[0],
        "FIRST": known.first.shape[1],
        "SECOND": known.second.shape[1],
        "INPUTS": pressed.INPUTS,
        "BIN": size,
        "BINS": pressed.LATEST + pressed.GROUP * pressed.AFTER,
        "GROUP": pressed.GROUP,
        "BEFORE": pressed.BEFORE,
        "AFTER": pressed.AFTER,
        "TRACE": pressed.TRACE,
        "START": pressed.START,
        "EARLIEST": pressed.EARLIEST,
        "LATEST": pressed.LATEST,
        "HAND": known.hand_mix.shape[0],
        "NUMBERS": known.hand_centre.size,
        "MEAN": mean_size(sampling),
        "EMPTY_POINTS": _empty_command().shape[1],
    }
    return {name: f"{value}" for name, value in values.items()}
