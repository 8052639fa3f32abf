"""MuJoCo stepped and called back by machine code, so that Python is not what is timed.

Callbacks are C functions that get MuJoCo's two structures; where their array pointers lie in
them is found once, by looking for the addresses that the Python objects show.
"""

import contextlib
import copy
import ctypes
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import mujoco
import numba
import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic

STRUCTURE = types.CPointer(types.CPointer(types.float64))  # mjModel or mjData, as its pointers
GENERIC = types.void(STRUCTURE, STRUCTURE)  # mjfGeneric
DYNAMICS = types.float64(STRUCTURE, STRUCTURE, types.int32)  # mjfAct
ADDRESS = ctypes.c_void_p
LONGEST = 100_000  # words; of mjData some 20,000
WILD = 1e6  # rad/s, of the motor: the run has diverged

_library = ctypes.CDLL(str(next(Path(mujoco.__file__).parent.glob("libmujoco*"))))
mj_step = _library.mj_step
mj_step.argtypes, mj_step.restype = [ADDRESS, ADDRESS], None


@intrinsic
def as_numbers(context: Any, structure: Any) -> Any:
    """The same structure, as its numbers."""

    def bits(context, builder, signature, arguments):
        return builder.bitcast(arguments[0], ir.DoubleType().as_pointer())

    return types.CPointer(types.float64)(structure), bits


def _search(structure: Any, kind: Any, wanted: float) -> int:
    """Words from the start of an MjModel or MjData to a value."""
    words = ctypes.cast(structure._address, ctypes.POINTER(kind))
    return next(k for k in range(LONGEST) if words[k] == wanted)


def _place(structure: Any, name: str) -> int:
    return _search(structure, ctypes.c_size_t, getattr(structure, name).ctypes.data)


_model = mujoco.MjModel.from_xml_string(
    '<mujoco><size nuserdata="1"/><worldbody><body><joint name="j"/><geom size="1"/></body>'
    '</worldbody><actuator><general joint="j" dyntype="integrator"/></actuator></mujoco>'
)
_data = mujoco.MjData(_model)
_data.time = 0.12345678901234567
TIME = _search(_data, ctypes.c_double, _data.time)
QPOS, QVEL, ACT, ACT_DOT, CTRL, USERDATA, QFRC_PASSIVE = (
    _place(_data, name)
    for name in ("qpos", "qvel", "act", "act_dot", "ctrl", "userdata", "qfrc_passive")
)
DOF_DAMPING, DOF_FRICTIONLOSS = (_place(_model, x) for x in ("dof_damping", "dof_frictionloss"))


@contextlib.contextmanager
def called_back(**callbacks: Any) -> Iterator[None]:
    """Install compiled callbacks by name (`passive`, `control`, `act_dyn`), MuJoCo silent."""
    prototype = ctypes.CFUNCTYPE(None, ADDRESS, ADDRESS)
    mujoco.set_mju_user_warning(lambda message: None)  # a run that diverges says so by its error
    for name, function in callbacks.items():
        pointer = ctypes.cast(function.address, prototype)
        getattr(mujoco, f"set_mjcb_{name}")(pointer)
    try:
        yield
    finally:
        for name in callbacks:
            getattr(mujoco, f"set_mjcb_{name}")(None)
        mujoco.set_mju_user_warning(None)


@numba.njit
def _march(quiet, sensing, data, qpos, qvel, act, sensed, every, rows, readings):
    nq, nv = qpos.size, qvel.size
    for k in range(rows.shape[0]):
        rows[k, :nq], rows[k, nq : nq + nv], rows[k, nq + nv :] = qpos, qvel, act
        mj_step(sensing, data)
        readings[k] = sensed
        if k + 1 == rows.shape[0] or not abs(qvel[0]) < WILD:
            return
        for _ in range(every - 1):
            mj_step(quiet, data)


@dataclass(frozen=True, eq=False)
class Launch:
    """A model ready to run: callbacks by name, start (userdata, angles of all hinges), sampling."""

    model: mujoco.MjModel
    callbacks: Mapping[str, Any]
    userdata: np.ndarray
    angles: np.ndarray
    samples: int
    every: int  # steps between two samples

    def __call__(self) -> np.ndarray:
        """qpos, qvel and act at the sample times in rows, NaN from where the run diverged."""
        return self._march(self.model)[0]

    def sensed(self) -> tuple[np.ndarray, np.ndarray]:
        """The same and what the model's sensors read at the sample times."""
        sensing = copy.copy(self.model)
        sensing.opt.disableflags &= ~int(mujoco.mjtDisableBit.mjDSBL_SENSOR)
        return self._march(sensing)

    def _march(self, sensing: mujoco.MjModel) -> tuple[np.ndarray, np.ndarray]:
        data = mujoco.MjData(self.model)
        data.userdata[:] = self.userdata
        data.qpos[3 : 3 + self.angles.size] = self.angles
        arrays = (data.qpos, data.qvel, data.act, data.sensordata)
        rows = np.full((self.samples, sum(each.size for each in arrays[:3])), np.nan)
        readings = np.full((self.samples, data.sensordata.size), np.nan)
        addresses = (self.model._address, sensing._address, data._address)
        with called_back(**self.callbacks):
            _march(*addresses, *arrays, self.every, rows, readings)
        return rows, readings
