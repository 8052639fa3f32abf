"""The benchmark `grip` on its development objects, on which settings were chosen: never quoted."""

from benchmarks.grip import bounds_of, rows_of, table_of
from benchmarks.harness import Row, main


def measure(quick: bool) -> tuple[list[Row], list[Row]]:
    """Rows and bounds."""
    found = rows_of(quick, "development")
    return table_of(found), bounds_of(found)


if __name__ == "__main__":
    main(__doc__, "gripping", measure)
