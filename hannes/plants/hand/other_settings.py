"""Settings that are other than the user says: how the hand is mounted, gains, limit of the current.

Each moves values of the hand, as a fault of one finger does, and adds nothing to the equations.
"""

from collections.abc import Mapping

from hannes.core.effect import Effect
from hannes.core.parameter import Parameter
from hannes.plants.part_fault import PartFault

WEIGHT = 9.81  # m/s2


def _amplitude(name: str, unit: str, bounds: tuple[float, float], doc: str) -> Parameter:
    return Parameter(name, 0.0, unit, bounds, doc, off=0.0)


def _mounting() -> PartFault:
    amplitudes = tuple(
        _amplitude(f"along_{axis}", "1", (-1.0, 1.0), f"gravity's share along {axis} of the hand")
        for axis in "xy"
    )
    return PartFault(
        "mounting",
        "The hand is mounted otherwise than stated, and gravity bends its fingers.",
        "g += 9.81 m/s^2 (along_x, along_y)",
        "Newton (1687); Featherstone (2008), gravity in a turned frame",
        amplitudes,
        (),
        moves={f"along_{axis}": {f"gravity.{axis}": WEIGHT} for axis in "xy"},
    )


def _gains(values: Mapping[str, float]) -> PartFault:
    kinds = ("proportional", "derivative")
    return PartFault(
        "firmware_gains",
        "The position loop in the firmware has other gains than stated.",
        "k_p *= 1 + proportional, k_d *= 1 + derivative",
        "Astrom & Hagglund (2006), PID with tuned gains",
        tuple(_amplitude(kind, "1", (-0.9, 4.0), f"change of the {kind} gain") for kind in kinds),
        (),
        moves={kind: {f"position_pid.{kind}": values[f"position_pid.{kind}"]} for kind in kinds},
    )


def _limit(values: Mapping[str, float]) -> PartFault:
    stated = values["position_pid.limit"]
    return PartFault(
        "current_limit",
        "The firmware limits the current at another value than stated.",
        "i_max += change",
        "the paper, section II: the current loop's reference is limited",
        (_amplitude("change", "A", (-0.975 * stated, 5.0 * stated), "of the limit"),),
        (),
        moves={"change": {"position_pid.limit": 1.0}},
    )


def other_settings(values: Mapping[str, float]) -> dict[str, Effect]:
    """By name; `values`: the hand's parameters as they are stated [SI]."""
    found = (_mounting(), _gains(values), _limit(values))
    return {each.name: each for each in found}
