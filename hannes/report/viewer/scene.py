"""One hand in motion, ready to be drawn: poses, wires, contacts and channels at common times."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from hannes.plants.hand.plant import HandPlant
from hannes.report.viewer.contacts import touches
from hannes.report.viewer.geometry import (
    Outlines,
    finger_outlines,
    finger_points,
    object_motion,
    outlines,
)
from hannes.report.viewer.replay import Replay
from hannes.simulation.hand.anatomy import JOINTS
from hannes.simulation.hand.hand import Hand
from hannes.simulation.hand.joint_shares import joint_value

MOST = 2400  # samples of a scene; a longer recording is thinned
SHOWN = ("position", "current", "duty", "force", "sensor", "supply")
WIRES = ("leader", "follower_a", "follower_b")
UNITS = {**HandPlant.channels, "leader_tension": "N"}


@dataclass(frozen=True, eq=False)
class Scene:
    """Everything that is drawn of one recording; n samples at `time` [s].

    points (n, 5, 4), contacts (n, 10, 4): see geometry.py and contacts.py. carts (n, 2) [m],
    motor (n,) [rad] at the output shaft, pose (n, 3) of the object. tension and stretch (n, 3) of
    `WIRES` [N, m]; forces (n, 10) normal, of the phalanges [N]. `recorded` and `simulated` hold
    channels (n,) by name. `every`: the scene has one of so many samples, and the last.
    `title`: of the experiment; `drawn_by`: which hand was simulated; `own`: it is the one that
    was recorded, too.
    """

    name: str
    note: str
    title: str
    drawn_by: str
    own: bool
    hand: Hand
    shape: str | None
    every: int
    time: np.ndarray
    points: np.ndarray
    contacts: np.ndarray
    carts: np.ndarray
    motor: np.ndarray
    pose: np.ndarray
    tension: np.ndarray
    stretch: np.ndarray
    forces: np.ndarray
    recorded: Mapping[str, np.ndarray]
    simulated: Mapping[str, np.ndarray]
    units: Mapping[str, str]

    @property
    def sections(self) -> Outlines | None:
        """The object's section in each finger's plane, None where there is no object."""
        return finger_outlines(self.hand, self.shape) if self.shape else None

    @property
    def slices(self) -> Outlines | None:
        """The object as drawn in space."""
        return outlines(self.hand, self.shape) if self.shape else None

    @property
    def step(self) -> float:
        """Time between two samples [s]: their median."""
        return float(np.median(np.diff(self.time)))

    def nearest(self, time: float) -> int:
        """The sample nearest to a time [s]."""
        return int(np.abs(self.time - time).argmin())

    def ended(self, time: float) -> bool:
        """Whether the recording is over, or has not begun, at a time [s]."""
        return not self.time[0] - self.step <= time <= self.time[-1] + self.step


def kept_rows(times: np.ndarray, moments: Sequence[float] = ()) -> tuple[np.ndarray, int]:
    """Rows of at most about MOST samples, and one of how many they are.

    The last sample is among them, and those nearest to `moments` [s].
    """
    every = -(-len(times) // MOST)
    asked = [int(np.abs(times - each).argmin()) for each in moments]
    return np.unique([*range(0, len(times), every), len(times) - 1, *asked]), every


def scene(shown: Replay, name: str, drawn_by: str = "", moments: Sequence[float] = ()) -> Scene:
    """Everything to draw of one recording, thinned to about MOST samples.

    The samples nearest to `moments` [s] are kept. drawn_by: the name of a hand other than the
    recording's own.
    """
    recording, hand, shape = shown.recording, shown.posed, shown.experiment.shape
    rows, every = kept_rows(recording.time, moments)
    times = recording.time[rows]
    states, layout = shown.states(times), shown.trajectory.compiled.states
    forces = shown.output("phalanx_force", times)
    points = finger_points(hand, states[:, layout["joint_angle"]])
    pose = object_motion(hand, states)
    contacts = np.zeros((len(times), 10, 4))
    if shape is not None:
        contacts = touches(hand, shape, points, pose, forces)
    carts = states[:, layout["cart_position"]]
    return Scene(
        name=name,
        note="",
        title=shown.experiment.title if recording.experiment else "",
        drawn_by=drawn_by,
        own=recording.source == "simulated" and not drawn_by,
        hand=hand,
        shape=shape,
        every=every,
        time=times,
        points=points,
        contacts=contacts,
        carts=carts,
        motor=states[:, layout["motor_angle"]][:, 0] / hand.parameters["gear.ratio"],
        pose=pose,
        tension=np.column_stack(
            [shown.output("leader_tension", times), shown.output("follower_tension", times)]
        ),
        stretch=_stretch(shown, hand, states, carts, times),
        forces=forces,
        recorded={each: recording[each][rows] for each in recording.names},
        simulated={each: shown.output(each, times) for each in (*SHOWN[:4], "leader_tension")},
        units={**UNITS, **recording.units},
    )


def _stretch(
    shown: Replay, hand: Hand, states: np.ndarray, carts: np.ndarray, times: np.ndarray
) -> np.ndarray:
    """Stretch of leader and both followers [m], shape (n, 3), negative while slack."""
    values, layout = hand.parameters, shown.trajectory.compiled.states
    angles = states[:, layout["joint_angle"]]
    arms = np.array([joint_value(values, joint, "moment_arm") for joint in JOINTS])
    rest = hand.rest(shown.trajectory.compiled)[layout["joint_angle"]]
    taken = ((angles - rest) * arms).reshape(len(times), 5, 2).sum(axis=2)
    followers = 2.0 * carts - np.stack([taken[:, 0:2].sum(1), taken[:, 2:4].sum(1)], axis=1)
    return np.column_stack([shown.output("leader_stretch", times), followers])
