"""Faults of one finger, by name: a weak spring, a wire off its pulley, a stiff joint, a moved stop.

Each has an amplitude for the finger's MCP and one for its PIP, and moves what that finger has for
itself (`[[finger]]` in a hand's file): a spring loses a share of what it has there.
"""

from collections.abc import Mapping

from hannes.core.effect import Effect
from hannes.core.parameter import Parameter
from hannes.plants.part_fault import PartFault
from hannes.simulation.hand import joint_shares
from hannes.simulation.hand.anatomy import FINGERS, PARAMETERS
from hannes.simulation.hand.joint_shares import KINDS

# Quantities of a joint that an amplitude moves -> relative change of their shares per unit of it.
_WEAK = {"spring_stiffness": -1.0, "spring_preload": -1.0}
_SLIPPED = {"moment_arm": -1.0}
_STIFF = {"breakaway_friction": 1.0, "coulomb_friction": 1.0, "viscous_friction": 1.0}


def _shares(
    finger: str, kind: str, changes: Mapping[str, float], values: Mapping[str, float]
) -> dict[str, float]:
    names = {f"{finger}.{kind}_{name}": change for name, change in changes.items()}
    return {name: change * values[name] for name, change in names.items()}


def _both(low: float, high: float) -> dict[str, tuple[float, float]]:
    """The same bounds for either joint."""
    return dict.fromkeys(KINDS, (low, high))


def _travel(finger: str, values: Mapping[str, float]) -> dict[str, tuple[float, float]]:
    """A stop may take nearly all of a joint's travel: beyond, the open hand would rest on it."""
    travels = {
        kind: values[f"{finger}.end_{kind}"] - values[f"{finger}.rest_{kind}"] for kind in KINDS
    }
    return {kind: (-0.99 * max(travel, 0.0), 0.3) for kind, travel in travels.items()}


def _fault(
    name: str,
    words: tuple[str, str, str],
    size: tuple[str, str, Mapping[str, tuple[float, float]], str],
    moves: Mapping[str, Mapping[str, float]],
) -> PartFault:
    meaning, equation, source = words
    amplitude, unit, bounds, doc = size
    parameters = tuple(
        Parameter(
            f"{kind}_{amplitude}", 0.0, unit, bounds[kind], f"{doc} of its {kind.upper()}", off=0.0
        )
        for kind in KINDS
    )
    named = {f"{kind}_{amplitude}": moves[kind] for kind in KINDS}
    kind = name.partition("_")[2]
    return PartFault(name, meaning, equation, source, parameters, (), moves=named, kind=kind)


def _of(finger: str, values: Mapping[str, float]) -> tuple[PartFault, ...]:
    shares = {
        what: {kind: _shares(finger, kind, changes, values) for kind in KINDS}
        for what, changes in (("weak", _WEAK), ("slipped", _SLIPPED), ("stiff", _STIFF))
    }
    return (
        _fault(
            f"{finger}_weak_spring",
            (
                f"A spring that opens the {finger} finger is weak or lost.",
                "T_spring *= 1 - lost, at one joint",
                "EN 13906-3 (2014), torsion springs: relaxation and fracture",
            ),
            ("lost", "1", _both(-1.0, 1.0), "share of the spring"),
            shares["weak"],
        ),
        _fault(
            f"{finger}_slipped_wire",
            (
                f"The wire of the {finger} finger runs beside its pulley, on another moment arm.",
                "a *= 1 - lost, at one joint",
                "geometry; Kaneko, Yamashita & Tanie (1991), tendon routing",
            ),
            ("lost", "1", _both(-0.5, 0.95), "share of the arm"),
            shares["slipped"],
        ),
        _fault(
            f"{finger}_stiff_joint",
            (
                f"A joint of the {finger} finger rubs more than those of the others.",
                "F *= 1 + more, at one joint",
                "Armstrong-Hélouvry (1991), friction by dirt and wear",
            ),
            ("more", "1", _both(-0.9, 30.0), "further friction"),
            shares["stiff"],
        ),
        _fault(
            f"{finger}_moved_stop",
            (
                f"A joint of the {finger} finger stops at another angle.",
                "q_end += angle, at one joint",
                "geometry of the stop; the paper's ranges of motion",
            ),
            ("angle", "rad", _travel(finger, values), "change of the closing stop"),
            {kind: {f"{finger}.end_{kind}": 1.0} for kind in KINDS},
        ),
    )


def faults(values: Mapping[str, float]) -> dict[str, Effect]:
    """By name; `values`: the hand's parameters as they are stated [SI]."""
    return {each.name: each for finger in FINGERS for each in _of(finger, values)}


FAULTS: Mapping[str, Effect] = faults(
    {each.name: each.value for each in (*PARAMETERS, *joint_shares.PARAMETERS)}
)
