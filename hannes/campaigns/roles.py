"""Roles of recordings: fit, validation (select) and test split (show), stratified by condition."""

from dataclasses import replace

import numpy as np

from hannes.campaigns.campaign import Entry


def with_roles(entries: list[Entry], seed: int) -> tuple[Entry, ...]:
    """Return the entries, those without a role given one at random.

    Of each condition a quarter goes to validation (select) and a quarter to the test split (show),
    one recording at least to each. The test share is rounded down: nothing is learned from it.
    Conditions with fewer than three recordings are pooled. The same `seed` gives the same roles.
    """
    rng = np.random.default_rng([seed, len(entries)])
    conditions: dict[str, list[int]] = {}
    for place, entry in enumerate(entries):
        if not entry.role:
            conditions.setdefault(entry.condition, []).append(place)
    groups = [places for places in conditions.values() if len(places) >= 3]
    groups.append([p for places in conditions.values() if len(places) < 3 for p in places])
    roles = {}
    for group in groups:
        shuffled = rng.permutation(group)
        for place, role in zip(shuffled, _shares(len(group)), strict=True):
            roles[int(place)] = role
    return tuple(
        replace(entry, role=roles.get(place, entry.role)) for place, entry in enumerate(entries)
    )


def _shares(count: int) -> list[str]:
    if count < 3:
        return ["fit", "show"][:count]
    select, show = max(1, round(count / 4)), max(1, count // 4)
    return ["select"] * select + ["show"] * show + ["fit"] * (count - select - show)
