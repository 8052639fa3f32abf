"""What a person does after a verdict, step by step."""

from collections.abc import Mapping, Sequence

LOOK = "On the machine, look where that sits."
TAKEN = 'An experiment takes it by hand = "hand.toml", a campaign by base = "hand.toml".'
SIMULATE = f"Simulate with hand.toml, which has what is named at its size. {TAKEN}"
WHERE = "See below where it disagrees, and look at that part of the machine."
APART = "Record another run that separates them."
OTHERS = "Record other runs: slower ones, other objects."
AGAIN = "Record each run as often as those before, add them to the campaign, and diagnose again."

STEPS: Mapping[str, Sequence[str]] = {
    "no_gap": ("Go on with the machine as it is; nothing needs to be added or refitted.",),
    "recalibrated": (
        f"Simulate with hand.toml, which has the refitted values; add no effect. {TAKEN}",
    ),
    "named": (LOOK, SIMULATE),
    "one_of": (
        "Add none of them yet; look at those parts of the machine.",
        APART,
        AGAIN,
    ),
    "named_with_remainder": (
        LOOK,
        SIMULATE,
        "See below where the rest is left: something else is missing there.",
    ),
    "unknown": (
        f"Add no effect yet. {WHERE}",
        OTHERS,
        AGAIN,
        "If nothing is named then, write an effect of your own (docs/how-to/add-an-effect.md).",
    ),
    "undecided": ("Record what the reason says is lacking.", AGAIN),
}


def next_steps(verdict: str, advice: str) -> list[str]:
    """What to do after a verdict, in order.

    advice: the run worth recording next, in a sentence, or an empty string
    """
    return [advice if advice and each in (APART, OTHERS) else each for each in STEPS[verdict]]
