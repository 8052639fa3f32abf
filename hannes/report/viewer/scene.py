"""One hand in motion, ready to be drawn: poses, wires, contacts and channels at common times."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from hannes.report.viewer.contacts import touches
from hannes.report.viewer.geometry import (
    Outlines,
    finger_outlines,
    finger_points,
    object_motion,
    outlines,
)
from hannes.report.viewer.replay import Replay
from hannes.simulation.hand.hand import Hand

MOST = 2400  # samples of a scene; a longer recording is thinned
SHOWN = ("position", "current", "duty", "force", "sensor", "supply")
WIRES = ("leader", "follower_a", "follower_b")
UNITS = {"leader_tension": "N"}


@dataclass(frozen=True, eq=False)
class Scene:
    """Everything that is drawn of one recording; n samples at `time` [s].

    points (n, 5, 4), contacts (n, 10, 4): see geometry.py and contacts.py. carts (n, 2) [m],
    motor (n,) [rad] at the output shaft, pose (n, 3) of the object. tension and stretch (n, 3) of
    `WIRES` [N, m]; forces (n, 10) normal, of the phalanges [N]. `recorded` and `simulated` hold
    channels (n,) by name. `every`: the scene has one of so many samples.
    """

    name: str
    note: str
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

    def nearest(self, time: float) -> int:
        """The sample nearest to a time [s]."""
        return int(np.abs(self.time - time).argmin())


def scene(shown: Replay, name: str, note: str = "") -> Scene:
    """Everything to draw of one recording, thinned to at most MOST samples."""
    recording, hand, shape = shown.recording, shown.posed, shown.experiment.shape
    every = -(-len(recording) // MOST)
    times = recording.time[::every]
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
        note=note,
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
        recorded={each: recording[each][::every] for each in recording.names},
        simulated={each: shown.output(each, times) for each in (*SHOWN[:4], "leader_tension")},
        units={**UNITS, **recording.units},
    )


def _stretch(
    shown: Replay, hand: Hand, states: np.ndarray, carts: np.ndarray, times: np.ndarray
) -> np.ndarray:
    """Stretch of leader and both followers [m], shape (n, 3), negative while slack."""
    values, layout = hand.parameters, shown.trajectory.compiled.states
    angles = states[:, layout["joint_angle"]]
    arms = np.array([values["mcp.moment_arm"], values["pip.moment_arm"]] * 5)
    rest = hand.rest(shown.trajectory.compiled)[layout["joint_angle"]]
    taken = ((angles - rest) * arms).reshape(len(times), 5, 2).sum(axis=2)
    followers = 2.0 * carts - np.stack([taken[:, 0:2].sum(1), taken[:, 2:4].sum(1)], axis=1)
    return np.column_stack([shown.output("leader_stretch", times), followers])
