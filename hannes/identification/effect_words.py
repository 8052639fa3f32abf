"""An effect's name as a sentence has it."""


def effect_words(name: str) -> str:
    """An effect's name in words: `leader_slack` -> `leader slack`."""
    words = name.rpartition(":")[2].replace("_", " ")
    # Alone it would read as "a slightly stiff joint".
    return f"little finger's {words[7:]}" if words.startswith("little ") else words
