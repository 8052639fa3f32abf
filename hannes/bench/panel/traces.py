"""What the page draws: measured samples, the model stepping beside them, recognition."""

import threading
from typing import Any

import numpy as np

from hannes.bench.events import About, Event, Restarted, Row
from hannes.bench.grip_loop import GripLoop
from hannes.bench.live import Decision, warm_up
from hannes.bench.virtual_hand import VirtualHand
from hannes.recognition.model import Estimate, Model
from hannes.simulation.experiment.experiment import Experiment
from hannes.simulation.hand.hand import Hand

EVERY = 5  # samples for one that is drawn
LONGEST_GAP = 200  # ticks without samples that the model steps through
MOST = 500  # drawn samples that wait for the page
MEASURED = ("reference", "position", "current")


class Traces:
    """Takes events, gives rows of time, MEASURED, and the model's position, current and force.

    Recognition and grip policy start with `begin`; without a trained model there is none. `known`:
    numbers of the measured hand's empty closure, None where there was none.
    `set_point`: what the policy makes of the command [rad]. `take` may be called from another
    thread.
    """

    def __init__(
        self,
        hand: Hand,
        experiment: Experiment,
        model: Model | None,
        known: np.ndarray | None = None,
    ) -> None:
        self._hand, self._experiment, self._trained, self._known = hand, experiment, model, known
        self._beside = VirtualHand(hand, experiment)
        self._beside.step(None)  # compiled before anything moves
        if model is not None:
            warm_up(model)
            GripLoop(model, hand=known)  # refused now, not once it grips
        self._loop: GripLoop | None = None
        self._about: About | None = None
        self._places: list[int] = []
        self._last, self._count, self._reference, self._position = -1.0, 0, 0.0, 0.0
        self._rows: list[list[float]] = []
        self._decision: Decision | None = None
        self._lock = threading.Lock()

    def begin(self) -> None:
        """A new grasp: the model is at rest, nothing is known of an object."""
        self._beside = VirtualHand(self._hand, self._experiment)
        self._decision = None
        self._loop = GripLoop(self._trained, hand=self._known) if self._trained else None
        if self._loop and self._about:
            self._loop.set_point = self._position
            self._loop.feed(self._about, self._position)

    @property
    def set_point(self) -> float:
        """What the grip policy makes of the command [rad]."""
        return self._loop.set_point if self._loop else 0.0

    def see(self, event: Event, moving: bool, wanted: float, sent: float) -> None:
        """Take one event; `moving`: the drive is on; command and last set point sent [rad]."""
        if isinstance(event, Restarted):
            self._last = -1.0
            self.begin()
        if isinstance(event, About):
            self._about = event
            names = list(event.channels)
            self._places = [names.index(each) if each in names else -1 for each in MEASURED]
            return
        self._recognise(event, wanted)
        if isinstance(event, Row) and self._about and event.time > self._last:
            self._sample(event, moving, sent)

    def _recognise(self, event: Event, wanted: float) -> None:
        if self._loop is None:
            return
        said = self._loop.feed(event, wanted)
        if said.released:
            self._decision = None
        elif said.decisions:
            self._decision = said.decisions[-1]

    def _sample(self, row: Row, moving: bool, sent: float) -> None:
        measured = [row.values[k] if k >= 0 else None for k in self._places]
        reference = measured[0]
        self._reference = sent if reference is None else reference
        self._position = self._position if measured[1] is None else measured[1]
        model = self._stepped(row.time, moving)
        self._last, self._count = row.time, self._count + 1
        if self._count % EVERY == 0:
            drawn = [row.time, *measured, model["position"], model["current"], model["force"]]
            with self._lock:
                self._rows.append(drawn)  # type: ignore[arg-type]
                del self._rows[:-MOST]

    def _stepped(self, time: float, moving: bool) -> dict[str, float]:
        """The model as many ticks on as the board is; a gap is gone through with one reference."""
        ticks = round((time - self._last) * self._beside.rate) if self._last >= 0.0 else 1
        values: dict[str, float] = {}
        for _ in range(min(max(ticks, 1), LONGEST_GAP)):
            values = self._beside.step(self._reference if moving else None)
        return values | {"force": self._beside.truth["force"]}

    def take(self) -> dict[str, Any]:
        """What is new since the last call, as JSON has it."""
        with self._lock:
            rows, self._rows = self._rows, []
        return {
            "rows": [[None if x is None else round(x, 5) for x in row] for row in rows],
            "recognised": _plain(self._decision),
        }


def _plain(decision: Decision | None) -> dict[str, Any] | None:
    if decision is None:
        return None
    return {
        "word": decision.word if decision.held or decision.stiffness else "",
        "rigid": round(decision.rigid, 3),
        "stiffness": _ends(decision.stiffness),
        "force": _ends(decision.force),
    }


def _ends(estimate: Estimate | None) -> list[float] | None:
    return [estimate.value, estimate.low, estimate.high] if estimate else None
