"""Recognition while the hand closes: the same decisions live and afterwards, bit for bit.

Samples enter in the order of the raw log. What is said at a moment follows from samples up to it
alone; a gap is bridged by a straight line once the next sample is there, as for a recording.
"""

import math
from collections import deque
from dataclasses import dataclass

import numpy as np

from hannes.bench.events import About, Event, Restarted, Row
from hannes.bench.onset import Onset
from hannes.core.errors import BadInput
from hannes.recognition import pressed
from hannes.recognition.features import CHANNELS, NAMES
from hannes.recognition.known_hand import points_of
from hannes.recognition.model import (
    LATER,
    SINCE,
    WORDS,
    Estimate,
    Model,
    decided,
    faded,
    grasp_peak,
    held,
    middle,
)
from hannes.recognition.windowing import GrowingFeatures

TOUCH = NAMES.index("touch_position")
NORMAL_95 = 1.96  # standard deviations to each end of a 95 % interval
LONGEST = 30.0  # s of one grasp; then a new one is taken to begin


@dataclass(frozen=True)
class Decision:
    """What is said at the end of one window; times in s since the grasp's start.

    board_time: of the newest sample that it rests on [s]; word: soft, rigid or don't know; rigid:
    probability; touched: whether a contact was detected, and the shaft's position there [rad];
    stiffness [N/m] and most force so far [N], with 95 % intervals, while something is held.
    pressed: stiffness [N/m] by the traces of a grasp that pressed on in doubt, once these are long
    enough; it holds only where the hand did press on, under the policy.
    """

    time: float
    board_time: float
    word: str
    rigid: float
    touched: bool
    touch_position: float
    held: bool
    stiffness: Estimate | None
    force: Estimate | None
    pressed: Estimate | None = None


def warm_up(model: Model) -> None:
    """Have recognition loaded and compiled before a hand moves: a second's delay stops it."""
    recogniser, windowing = LiveRecogniser(model), model.windowing
    recogniser.feed(About("none", dict.fromkeys(CHANNELS, "1"), windowing.sampling, 0.0))
    for k in range(2 * windowing.size + 1):
        recogniser.feed(Row(k, k / windowing.sampling, (0.0, 0.0, 0.0)))
    model.force.quantiles(np.zeros((1, len(NAMES)), np.float32))
    if model.pressed and pressed.bin_size(windowing.sampling):
        samples = np.zeros((3, round(windowing.sampling)))
        row = pressed.trace_inputs(samples, round(0.3 * windowing.sampling), windowing.sampling)
        model.pressed(row[np.newaxis])
        model.pressed.points(model.pressed.hand_centre)


def channel_places(about: About) -> list[int]:
    """Places of current, position, reference in a board's rows; BadInput where one is missing."""
    names = list(about.channels)
    for name in CHANNELS:
        if name not in names:
            raise BadInput(f'the board sends no channel "{name}"; recognition needs it')
    return [names.index(name) for name in CHANNELS]


class LiveRecogniser:
    """Takes events of a board, gives decisions. Raises BadInput where a channel is missing.

    hand: numbers of its empty closure (known_hand.py), None for a hand that is not known; BadInput
    where they are not as many as the model takes, or unlike all that it learned from.
    """

    def __init__(self, model: Model, hand: np.ndarray | None = None) -> None:
        self.model, self._onset = model, Onset()
        self._hand = None if hand is None else points_of(hand, model)
        self._places: list[int] | None = None
        self.begin(0.0)

    def feed(self, event: Event) -> list[Decision]:
        """Take one event; return the decisions that it allows, often none."""
        if isinstance(event, Row) and self._places is not None:
            return self._sample(event)
        if isinstance(event, About):
            self._places = channel_places(event)
        elif isinstance(event, Restarted):
            self.begin(event.time)
        elif (began := self._onset.feed(event)) is not None:
            self.begin(began)
        return []

    def begin(self, board_time: float) -> None:
        """Forget what was seen: a grasp begins at `board_time` [s]."""
        self._start, self._first, self._last = board_time, 0.0, -math.inf
        self._newest: tuple[float, np.ndarray] | None = None
        self._features = GrowingFeatures(self.model.windowing)
        self._odds = 0.0  # fading mean of the log odds
        self._held: deque[np.ndarray] = deque(maxlen=LATER)  # quantiles of stiffness, newest
        self._windows_held = 0
        self._pressed: Estimate | None = None
        self._asked = False  # whether the traces were long enough already

    def _sample(self, row: Row) -> list[Decision]:
        since = row.time - self._start
        if since < -1e-9 or since <= self._last:
            return []  # before the start, or a frame sent again: too late for live
        if since > LONGEST:
            self.begin(row.time)
            since = 0.0
        values = np.array([row.values[k] for k in self._places or ()])
        rows = self._features.take(self._on_grid(since, values))
        self._last, self._newest = since, (since, values)
        return [self._decision(*each, row.time) for each in rows]

    def _on_grid(self, since: float, values: np.ndarray) -> list[np.ndarray]:
        """Samples of the model's grid up to the newest, on straight lines between those there."""
        sampling, newest = self.model.windowing.sampling, self._newest
        if newest is None:
            self._first = since
            return [values]
        last = int((since - self._first) * sampling + 1e-6)
        near = np.array([newest[0], since]) - self._first
        pair = np.array([newest[1], values])
        return [
            np.array([np.interp(k / sampling, near, column) for column in pair.T])
            for k in range(self._features.count, last + 1)
        ]

    def _decision(self, window: int, row: np.ndarray, board_time: float) -> Decision:
        """What is said at the end of a window with features `row` (1, features)."""
        model, touched, holds = self.model, bool(row[0, SINCE] > 0.0), bool(held(row)[0])
        self._odds = faded(self._odds, float(model.windows(row)[0]), touched, model.windowing.hop)
        if holds:
            self._held.append(model.stiffness.quantiles(row)[0])
            self._windows_held += 1
        probability, stiffness, force = 0.5, None, None
        if self._windows_held:
            probability = float(1.0 / (1.0 + np.exp(-self._odds)))
            later = min(self._windows_held - self._windows_held // 2, LATER)
            value, apart = middle(np.array(self._held)[-later:])
            stiffness = Estimate(value, *model.stiffness_band(value, apart))
        if holds:
            value, apart = grasp_peak(model.force.quantiles(row)[0])
            force = Estimate(value, *model.force_band(value, apart))
        word = WORDS[int(decided(np.array([probability]), model.sure)[0])]
        time = model.windowing.time_of(window)
        self._ask(window)
        return Decision(
            time, board_time, word, probability, touched, float(row[0, TOUCH]), holds, stiffness,
            force, self._pressed,
        )  # fmt: skip

    def _ask(self, window: int) -> None:
        """Have the stiffness by the traces once these are long enough at the end of a window."""
        known, windowing, touch = self.model.pressed, self.model.windowing, self._features.touch
        if self._asked or known is None or touch is None:
            return
        needed = pressed.due(touch, pressed.bin_size(windowing.sampling))
        if needed is None or windowing.seen(window) < needed:
            return
        self._asked = True
        row = pressed.trace_inputs(self._features.samples, touch, windowing.sampling)
        value = float(known(row[np.newaxis], self._hand)[0])
        if math.isfinite(value):
            ends = NORMAL_95 * known.error[pressed.UNKNOWN if self._hand is None else pressed.KNOWN]
            low, middle_, high = (float(np.exp(value + each)) for each in (-ends, 0.0, ends))
            self._pressed = Estimate(middle_, low, high)
