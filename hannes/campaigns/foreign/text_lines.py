"""Lines of text in little memory: a list of them takes fifty bytes a line besides the text."""

from array import array
from collections.abc import Iterator


class Lines:
    """Lines one after another in one buffer; taken out one by one, as often as needed."""

    def __init__(self) -> None:
        self._text, self._ends = bytearray(), array("q")

    def append(self, line: str) -> None:
        """Add a line at the end."""
        self._text += line.encode("utf-8", "surrogatepass")
        self._ends.append(len(self._text))

    def __len__(self) -> int:
        return len(self._ends)

    def __getitem__(self, row: int) -> str:
        start = self._ends[row - 1] if row else 0
        return self._text[start : self._ends[row]].decode("utf-8", "surrogatepass")

    def __iter__(self) -> Iterator[str]:
        return map(self.__getitem__, range(len(self)))
