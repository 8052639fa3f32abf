"""How much one diagnosis may simulate: an answer always comes, and its cost is known before.

Processor time would end a search elsewhere on another machine. So simulated time is counted, which
is the same everywhere. A run with the sampled controller counts more, as it takes more steps. So
does a run whose plant says that it took more (a ripple, say, which the solver must follow). Runs
that go side by side by the steps of the first one count less. Of a slow command a plant may count
less: its solver takes long steps there.
Everything counts: the choice of a controller, baseline fits, all starts, the search, hold-out, the
final fit and the run proposed next; the shape of an unknown has a bound of its own. Whatever comes
first must leave the rest less. Only what every verdict needs is made in any case: the machine as
given with its derivatives, and the closing.
"""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import TypeVar

from hannes.identification.diagnosis.settings import MOST_WORK
from hannes.identification.diagnosis.tuning import SEARCH, SHAPE

T = TypeVar("T")


def ordinary_time(plant: object, duration: float) -> float:
    """What a run of a duration [s] counts by the clock of an ordinary one [s]."""
    return min(duration, float(getattr(plant, "longest_counted", duration)))


class SearchEnded(Exception):
    """The diagnosis has simulated as much as it may."""


class Work:
    """Simulated time [s] spent so far, weighted; SearchEnded beyond the limit where `bounded`.

    times: factor on the usual limit
    """

    def __init__(self, bounded: bool = False, times: int = 1) -> None:
        self.times, self.spent, self.bounded = times, 0.0, bounded
        self.limit = times * SEARCH.most_simulated
        self._closing = self._rivals = False

    def add(self, runs: float, duration: float, exact: bool) -> float:
        """Count runs before they are made, and say as how much [s].

        SearchEnded where that is more than the limit.
        """
        cost = runs * duration * (SEARCH.exact_weight if exact else 1.0)
        if self.bounded and self.spent + cost > self.limit:
            raise SearchEnded
        self.spent += cost
        return cost

    def taken(self, made: list[T], counted: float, share: float = 1.0) -> list[T]:
        """Runs once made, after counting what they took beyond what `add` counted [s].

        A plant says that by `work` of the list, as seconds of ordinary runs, of which such runs
        take a share.
        """
        self.spent += max(0.0, share * getattr(made, "work", 0.0) - counted)
        return made

    def extended(self) -> None:
        """Give what judges and closes a search some work of its own, once."""
        self._closing = self._more(SEARCH.closing_simulated, self._closing)

    def extended_for_rivals(self) -> None:
        """Give what could stand in for several effects some work of its own, once."""
        self._rivals = self._more(SEARCH.rivals_simulated, self._rivals)

    def _more(self, seconds: float, given: bool) -> bool:
        """Raise the limit [s], unless that was given before."""
        if not given:
            self.limit = max(self.limit, self.spent) + seconds
        return True

    @contextmanager
    def in_any_case(self) -> Iterator[None]:
        """Within, runs are counted and made although the limit is reached."""
        before, self.bounded = self.bounded, False
        try:
            yield
        finally:
            self.bounded = before

    def most(self, durations: Sequence[float], uncertain: int) -> float:
        """What a diagnosis of commands of these durations [s] may simulate, weighted [s].

        uncertain: number of parameters of the machine
        """
        needed = SEARCH.needed_runs + SEARCH.needed_per_parameter * uncertain
        own = SEARCH.rivals_simulated + SEARCH.closing_simulated + SHAPE.most_simulated
        return self.limit + own + needed * sum(durations)

    @property
    def ended(self) -> str:
        """What a verdict says where it ended the search."""
        bound, twice = self.times * SEARCH.most_simulated, 2 * self.times
        more = f"; work = {twice} in [diagnose] lets it last twice as long"
        more = more if twice <= MOST_WORK else ""
        return (
            f"the search was ended at its bound, {bound:,.0f} s of single runs: nothing "
            f"is named by half a search{more}"
        )


def as_single(rows: int) -> float:
    """As how many single runs count some that go side by side by the steps of the first one."""
    return SEARCH.alike_call + SEARCH.alike_weight * rows
