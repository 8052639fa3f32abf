"""Frames that were lost on the way are asked for again, while the board still keeps them."""

from hannes.bench.events import Event, Row
from hannes.bench.session import Session

MOST = 0xFFFF  # frames of one request
AT_THE_END = 0.25  # s for which what was asked for last is awaited


class AskAgain:
    """Asks once for each gap as it shows, and once more at the end; boards without a ring refuse.

    Frames that come late fill their gap: they are in the recording as if nothing had been lost.
    """

    def __init__(self, talk: Session) -> None:
        self._talk, self._asked = talk, 0  # frames before this number were asked for
        talk.watch = self._see

    def at_the_end(self) -> None:
        """Ask for all that is missing still, and wait a little for it."""
        if self._ask_from(0):
            self._talk.wait(lambda: not self._talk.missing, AT_THE_END)

    def _see(self, event: Event) -> None:
        if isinstance(event, Row):
            self._ask_from(self._asked)

    def _ask_from(self, number: int) -> bool:
        """Ask for gaps that begin at `number` or later; False where there is none."""
        talk, newest_first = self._talk, reversed(self._talk.missing)
        gaps = []
        for first, stop in newest_first:
            if first < number:
                break
            gaps.append((max(first, stop - MOST), stop))
        for first, stop in gaps:
            talk.reader.send(talk.speaker.resend(first, stop - first))
        self._asked = max([self._asked, *(stop for _, stop in gaps)])
        return bool(gaps)
