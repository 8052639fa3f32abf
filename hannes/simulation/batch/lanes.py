"""What groups of grasps share that go side by side in the lanes of vector registers."""

import sys
import threading
from collections.abc import Iterable

import numpy as np

from hannes.simulation.compiled_call import Plan, Ran
from hannes.simulation.compiler.assemble import Compiled
from hannes.simulation.compiler.lanes import machine
from hannes.simulation.compiler.lanes.kernels import Kernels, is_kept
from hannes.simulation.compiler.lanes.values import NotInLanes
from hannes.simulation.rodas.coefficients import LOOSE

COMPILING = 6.0  # s, that grasps take one by one before code for lanes is compiled
PAYS = {"in_step": 1.0, "own_steps": 3.0}  # times as long, for as much less is gained
FULL = 0.6  # of the lanes: a group that fills fewer is as quick one by one
TURN = 64  # steps between two looks at whether to stop

_made: dict[tuple[Compiled, tuple[int, ...], int, str], Kernels | None] = {}
_spent: dict[Compiled, float] = {}  # s, by grasps that went one by one
_compiling = threading.Lock()


def kernels(plan: Plan, count: int, entry: str, width: int | None = None) -> Kernels | None:
    """Machine code for several grasps at once; None where one at a time is as good, or all we have.

    What is not kept on disk is compiled once grasps of the model that went one by one have taken so
    long that compiling pays.
    """
    width, compiled = machine.width() if width is None else width, plan.compiled
    structured = compiled.jacobian_kind == "structured"
    if width < 2 or count < 2 or plan.sampled or not structured:
        return None
    key = (compiled, tuple(plan.columns.tolist()), width, entry)
    with _compiling:
        spent = _spent.get(compiled, 0.0)
        if key not in _made and (spent > PAYS[entry] * COMPILING or is_kept(*key)):
            try:
                _made[key] = Kernels(*key)
            except (NotInLanes, RuntimeError, ArithmeticError) as why:  # these two: of LLVM
                print(f"hannes: grasps run one by one, for {why}", file=sys.stderr, flush=True)
                _made[key] = None
        return _made.get(key)


def one_by_one(
    plan: Plan, vectors: np.ndarray, starts: np.ndarray, stop: np.ndarray,
    path: np.ndarray | None = None,
) -> Ran:  # fmt: skip
    """`Plan.run`, whose time counts towards compiling."""
    ran = plan.run(vectors, starts, stop, path)
    _spent[plan.compiled] = _spent.get(plan.compiled, 0.0) + ran.seconds
    return ran


def in_order(parts: Iterable[tuple[np.ndarray, Ran]], seconds: float) -> Ran:
    """What parts of a batch left, each with the rows that it had."""
    rows, rans = zip(*parts, strict=True)
    order = np.argsort(np.concatenate(rows))
    kept, counts = (
        np.concatenate([getattr(ran, name) for ran in rans])[order] for name in ("kept", "counts")
    )
    return Ran(rans[0].rows, rans[0].memories, kept, counts, seconds)


class Lanes:
    """Where groups of grasps are worked on, one after the other.

    `at`: arrays of the workspace by name.
    """

    def __init__(self, plan: Plan, made: Kernels) -> None:
        self.plan, self.made = plan, made
        self.method = int(plan.rtol >= LOOSE)
        self.at = self.workspace()

    def workspace(self, alone: bool = False) -> dict[str, np.ndarray]:
        """An empty one with the plan's reference; `alone`: see `Kernels.room`."""
        at = self.made.room(alone)
        at["reference"][:] = self.plan.knots.ctypes.data, *self.plan.knots.shape
        return at

    def fill(self, vectors: np.ndarray, starts: np.ndarray) -> None:
        """Give each lane a grasp; lanes that are left have the first one's numbers."""
        size, at = vectors.shape[0], self.at
        chosen = [*range(size), *[0] * (self.made.width - size)]
        at["p"][:] = vectors[chosen].T
        with np.errstate(all="ignore"):
            np.divide(1.0, at["p"], out=at["p_over"])
        at["state"][0] = starts[chosen].T
        at["alive"][0] = np.arange(self.made.width) < size


def begin(at: dict[str, np.ndarray]) -> int:
    """Address of a workspace."""
    address: int = next(iter(at.values())).ctypes.data
    return address
