"""The data check of all recordings, before any of them is fitted."""

from hannes.campaigns.campaign import Campaign
from hannes.campaigns.check import check
from hannes.campaigns.mixed_runs import mixed_runs, several_units
from hannes.campaigns.quality.finding import Finding
from hannes.core.errors import BadInput

DataIssues = tuple[tuple[str, Finding], ...]  # each with the name of its recording


def data_issues(campaign: Campaign, accepted: tuple[str, ...]) -> DataIssues:
    """Return all faults and warnings; BadInput where one is of no kind that is `accepted`.

    A fit believes every sample. So what misleads only in part is refused as well, until the
    campaign accepts it.
    """
    found = tuple(
        (entry.name, each)
        for entry in campaign.entries
        for each in check(entry.recording, campaign.plant)
        if each.level != "note"
    )
    gross = (each for each in mixed_runs(campaign) if each.level == "fault")
    across = (*gross, *several_units(campaign))
    found += tuple(("the campaign", each) for each in across)
    refused = [(name, each) for name, each in found if each.kind not in accepted]
    if refused:
        name, first = refused[0]
        more = f" ({len(refused) - 1} more: see `hannes check`)" if len(refused) > 1 else ""
        raise BadInput(
            f'{name}: {first}{more}; or take it as it is with [calibrate] accept = ["{first.kind}"]'
        )
    return found
