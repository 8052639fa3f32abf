"""What a person does after a verdict, in one sentence each."""

from collections.abc import Mapping

NEXT: Mapping[str, str] = {
    "no_gap": "Go on with the machine as it is; nothing needs to be added or refitted.",
    "recalibrated": "Simulate with hand.toml, which has the refitted values; add no effect.",
    "named": (
        "Simulate with hand.toml, which has what is named at its size; on the machine, look where "
        "that sits."
    ),
    "one_of": (
        "Look at those parts of the machine, or record another run that separates them; add none "
        "of them before."
    ),
    "named_with_remainder": (
        "Simulate with hand.toml, which has what is named at its size; then look below for where "
        "the rest is left, for something else is missing there."
    ),
    "unknown": (
        "Add no effect yet. Look below for where it disagrees, and at that part of the machine; "
        "record other runs, or write an effect of your own."
    ),
    "undecided": "Record what the reason says is lacking, and diagnose again.",
}
