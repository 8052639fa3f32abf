"""The hand whose TOML text a recording or an FMU carries."""

from hannes.core.io.toml_table import Table
from hannes.core.trust.python_source import is_own
from hannes.simulation.hand.hand import Hand
from hannes.simulation.hand.hand_file import KEYS, changed

RECORDED = "the recording's hand"


def hand_of(
    text: str, where: str = RECORDED, advice: str = "name the hand with --hand HAND.toml"
) -> Hand:
    """The hand of a TOML text, the shipped one where it is empty.

    Raises BadInput where the text names an effect of a file: to look at a recording runs no code
    that came with it; `advice` says what to do.
    """
    if not text:
        return Hand()
    table = Table.parse(text, where, KEYS)
    for name in table.texts("effects"):
        if is_own(name):
            table.refuse("effects", f'has "{name}" of a file: {advice}')
    return changed(Hand(), table, None)
