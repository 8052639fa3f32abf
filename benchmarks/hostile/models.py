"""A model and a data set, as small as they can be."""

import io
from pathlib import Path

import numpy as np


def model_bytes() -> bytes:
    """A model of two trees of three nodes in each forest."""
    import tempfile

    from hannes.recognition import model_file
    from hannes.recognition.forest import Forest
    from hannes.recognition.model import Band, Calibration, Model
    from hannes.recognition.pressed import INPUTS, PressedStiffness
    from hannes.recognition.windowing import Windowing

    def forest(low: float, high: float) -> Forest:
        return Forest(
            np.array([0, 3, 6]),
            np.array([1, -1, -1] * 2),
            np.array([2, -1, -1] * 2),
            np.array([0, 0, 0] * 2),
            np.array([0.5, 0.0, 0.0] * 2),
            np.array([0.0, low, high] * 2),
        )

    rising = np.array([0.0, 1.0])
    band = Band(rising, -rising - 0.1, rising + 0.1)
    made = Model(
        Windowing(),
        5500.0,
        0.6,
        rigid=forest(0.1, 0.9),
        stiffness=forest(6.0, 9.0),
        force=forest(0.1, 2.0),
        peak=None,
        calibration=Calibration(rising, rising),
        stiffness_band=band,
        force_band=band,
        trained="by hand",
        pressed=PressedStiffness(
            np.zeros(INPUTS),
            np.full((2, INPUTS), 0.01, np.float32),
            np.zeros(4),
            np.full((1, 4), 0.01, np.float32),
            *(np.full(shape, 0.5, np.float32) for shape in ((1, 2, 4), (1, 2, 3), (1, 1, 3))),
            np.array([10.0, 5.0]),
            np.array([0.1, 0.05]),
        ),
    )
    with tempfile.TemporaryDirectory() as folder:
        model_file.write(Path(folder) / "model.h5", made)
        return (Path(folder) / "model.h5").read_bytes()


GRASPS, TIMES = 24, 1e-3 * np.arange(1200)
TOUCH, LET_GO = 0.3, 0.9  # s


def data_set_bytes() -> bytes:
    """A data set of 24 grasps, soft and rigid in turn, of which a model can be trained."""
    import h5py

    from hannes.core.recording.hdf5 import set_attribute

    memory = io.BytesIO()
    fields = [("role", "<i1"), ("completed", "<i1"), ("contact", "<f8"), ("release", "<f8")]
    rows = np.ones(GRASPS, [*fields, ("peak_force", "<f8"), ("object.stiffness", "<f8")])
    rows["role"] = [0] * 18 + [1] * 3 + [2] * 3
    rows["contact"], rows["release"], rows["peak_force"] = TOUCH, LET_GO, 100.0
    rows["object.stiffness"] = [800.0, 20e3] * (GRASPS // 2)
    with h5py.File(memory, "w") as file:
        texts = {"schema": "hannes-dataset-1", "roles": '["train", "test", "pressed"]'}
        for key, text in {**texts, "title": "some", "fingerprint": "0"}.items():
            set_attribute(file, key, text)
        file.attrs["border"] = 5500.0
        file["grasps"] = rows
        file["channels/time"] = TIMES
        for name, values in grasps(rows["object.stiffness"] > 5500.0).items():
            kept = values.astype("<f4")
            file.create_dataset(f"channels/{name}", data=kept, compression="gzip", shuffle=True)
    return memory.getvalue()


def grasps(rigid: np.ndarray) -> dict[str, np.ndarray]:
    """Channels by grasp, shape (grasps, samples): closing, touching, squeezing, letting go."""
    command = np.interp(TIMES, [0.0, 0.6, LET_GO, 1.2], [0.0, 9.0, 9.0, 0.0])
    pressed = np.interp(TIMES, [TOUCH, 0.6, LET_GO, LET_GO + 0.1], [0.0, 1.0, 1.0, 0.0])
    hard = np.where(rigid, 1.0, 0.3) * np.linspace(0.9, 1.1, rigid.size)
    hard = hard[:, np.newaxis]
    return {
        "reference": np.tile(command, (rigid.size, 1)),
        "position": command * (1.0 - 0.3 * hard * pressed),
        "current": 0.3 + 2.0 * hard * pressed,
        "force": 60.0 * hard * pressed,
    }
