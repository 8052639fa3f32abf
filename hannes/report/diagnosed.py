"""What the page of a diagnosis is drawn from."""

from collections.abc import Mapping, Sequence
from typing import Protocol

from hannes.campaigns.campaign import Campaign
from hannes.identification.diagnosis.campaign_diagnosis import Result
from hannes.identification.residuals import Traces
from hannes.identification.verdict import Verdict
from hannes.plants.protocol import Plant


class Diagnosis(Protocol):
    """A diagnosis, as far as its page and figures read it."""

    @property
    def campaign(self) -> Campaign:
        """The recordings with their roles, and the plant as it was given."""

    @property
    def verdict(self) -> Verdict:
        """What is claimed, and the figures behind it."""

    @property
    def plant(self) -> Plant:
        """The plant with what was found."""

    @property
    def traces(self) -> Sequence[Traces]:
        """Measured and simulated channels of each recording that is drawn."""

    @property
    def noise_floors(self) -> Mapping[str, float]:
        """Noise floor of each judged channel, in the channel's unit."""

    @property
    def details(self) -> Result | None:
        """What the verdict came from, where the plant declares what of it is uncertain."""
