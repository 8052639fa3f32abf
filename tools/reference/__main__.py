"""Write the generated pages of docs/reference; with --check only say which are out of date."""

import argparse
import sys

from tools.reference import FOLDER, PAGES, written


def main() -> int:
    """Exit status 1 where --check finds a page that is not what the code says."""
    parser = argparse.ArgumentParser(prog="python -m tools.reference", description=__doc__)
    parser.add_argument("--check", action="store_true", help="write nothing")
    asked = parser.parse_args()
    stale = []
    for name in PAGES:
        path, text = FOLDER / name, written(name)
        if path.exists() and path.read_text(encoding="utf-8") == text:
            continue
        stale.append(name)
        if not asked.check:
            path.write_text(text, encoding="utf-8", newline="\n")
    word = "out of date" if asked.check else "written"
    print("\n".join(f"{word}: docs/reference/{name}" for name in stale) or "all up to date")
    return int(bool(stale) and asked.check)


if __name__ == "__main__":
    sys.exit(main())
