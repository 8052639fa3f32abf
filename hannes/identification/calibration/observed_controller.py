"""Firmware that a campaign does not speak of: encoder counts in the recordings show it.

Who names a shipped experiment takes its continuous controller along. A recorded position that
stands in whole counts of the machine's encoder was read by firmware, and its ticks and rounding
shift currents by more than noise. So the sampled controller is taken, and said.
"""

from dataclasses import replace

from hannes.campaigns.campaign import Campaign

SAID = (
    "experiments say a continuous controller, or there are none, and the recorded positions are "
    "whole counts of the encoder: firmware's sampled controller was taken"
)


def as_recorded(campaign: Campaign) -> tuple[Campaign, str]:
    """The campaign under the controller that its recordings show, and what was changed or ""."""
    sampled, counted = (getattr(campaign.plant, name, None) for name in ("sampled", "counted"))
    if sampled is None or counted is None:
        return campaign, ""
    made = [sampled(each.recording) for each in campaign.entries]
    if not any(made) or not all(counted(each.recording) for each in campaign.entries):
        return campaign, ""
    entries = tuple(
        each if other is None else replace(each, recording=other)
        for each, other in zip(campaign.entries, made, strict=True)
    )
    return replace(campaign, entries=entries), SAID
