"""How much one diagnosis may simulate: an answer always comes, and its cost is known before.

Processor time would end the search elsewhere on another machine. So simulated time is counted,
which is the same everywhere. A run with the sampled controller counts more, as it takes more steps.
"""

from hannes.identification.diagnosis.tuning import SEARCH


class SearchEnded(Exception):
    """The search has simulated as much as it may."""


class Work:
    """Simulated time [s] spent so far, weighted; `bounded` while a search may be ended by it."""

    def __init__(self) -> None:
        self.limit, self.spent, self.bounded = SEARCH.most_simulated, 0.0, False

    def add(self, runs: int, duration: float, exact: bool) -> None:
        """Count runs before they are made; SearchEnded where that is more than the limit."""
        self.spent += runs * duration * (SEARCH.exact_weight if exact else 1.0)
        if self.bounded and self.spent > self.limit:
            raise SearchEnded

    def text(self, duration: float) -> str:
        """The bound in words, for runs of this mean duration [s]."""
        return f"at most {self.limit / duration:,.0f} simulations"

    @property
    def ended(self) -> str:
        """What a verdict says where it ended the search."""
        return (
            f"the search was ended at its bound, {self.limit:,.0f} s of simulated runs: "
            "nothing is named by half a search"
        )
