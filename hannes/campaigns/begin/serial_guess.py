"""Whether a text is a serial monitor's: stamps before lines, or a name before each value."""

from collections.abc import Callable, Sequence

from hannes.campaigns.foreign.serial_lines import (
    STAMPED,
    SerialForm,
    apart,
    named_values,
    serial_form,
)

MOST = 0.6  # share of lines that must be so
MARKS = (":", "=")
DELIMITERS = (",", ";", "\t", " ")


def is_stamped(lines: Sequence[str]) -> bool:
    """Whether most lines begin with a stamp and an arrow."""
    written = [line for line in lines if line.strip()]
    return sum(STAMPED.match(line) is not None for line in written) > MOST * len(written)


def pairs_of(lines: Sequence[str], stamped: bool) -> tuple[str, str]:
    """Delimiter and mark by which most lines are names with numbers, empty texts for none."""
    rests = [rest for line in lines if (rest := apart(line)[1] if stamped else line).strip()]
    for delimiter in DELIMITERS:
        for mark in MARKS:
            found = (named_values(rest, delimiter, mark) for rest in rests)
            count = sum(bool(each) and all(map(_named_number, each.items())) for each in found)
            if rests and count > MOST * len(rests):
                return delimiter, mark
    return "", ""


def _named_number(pair: tuple[str, str]) -> bool:
    name, value = pair
    try:
        float(value)
    except ValueError:
        return False
    return not name[:1].isdigit()  # 12:30 is a time


def form_of(lines: Sequence[str], cut: Callable[[Sequence[str]], str]) -> SerialForm | None:
    """The form of a serial monitor's lines, None for other text; `cut` finds a delimiter."""
    stamped = is_stamped(lines)
    delimiter, mark = pairs_of(lines, stamped)
    if not stamped and not mark:
        return None
    rests = [apart(line)[1] if stamped else line for line in lines]
    return serial_form(lines, delimiter or cut(rests), stamped, mark)
