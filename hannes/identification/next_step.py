"""What a person does after a verdict, step by step."""

from collections.abc import Mapping, Sequence

LOOK = "On the machine, look where that sits."
TAKEN = (
    "An experiment of the hand takes the path of that file as its hand, a campaign of any machine "
    "as its base."
)
SIMULATE = f"Simulate with this result's hand.toml, which has what is named at its size. {TAKEN}"
APART = "Record another run that separates them."
OTHERS = "Record other runs: slower ones, other objects."
AGAIN = "Record each run as often as those before, add them to the campaign, and diagnose again."

STEPS: Mapping[str, Sequence[str]] = {
    "no_gap": ("Go on with the machine as it is; nothing needs to be added or refitted.",),
    "recalibrated": (
        "Simulate with this result's hand.toml, which has the refitted values; add no effect. "
        f"{TAKEN}",
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
        "See where the rest is left: something else is missing there.",
    ),
    "unknown": (
        "Add no effect yet. See where it disagrees, and look at that part of the machine.",
        OTHERS,
        AGAIN,
        "If nothing is named then, write an effect of your own (docs/tutorials/your-effect.md).",
    ),
    "undecided": (
        "Record what the reason says is lacking, add it to the campaign, and diagnose again.",
    ),
}


def next_steps(verdict: str, advice: str) -> list[str]:
    """What to do after a verdict, in order.

    advice: the run worth recording next, in a sentence, or an empty string
    """
    return [advice if advice and each in (APART, OTHERS) else each for each in STEPS[verdict]]
