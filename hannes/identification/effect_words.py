"""An effect's name as a sentence has it."""

FAULTS = ("stiff joint", "weak spring", "slipped wire", "moved stop")  # else: slightly stiff


def effect_words(name: str) -> str:
    """An effect's name in words: `leader_slack` -> `leader slack`."""
    words = name.rpartition(":")[2].replace("_", " ")
    part, _, fault = words.partition(" ")
    return f"little finger's {fault}" if part == "little" and fault in FAULTS else words
