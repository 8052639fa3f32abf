"""Licences of all that `make run` and `make test` install: `python -m tools.licences`.

They are read from the metadata of what is installed. Ends with status 1 where a package of the
core is copyleft (GPL, LGPL, AGPL) or does not say. MPL is allowed: it asks only for its own files.
"""

import re
import sys
from collections.abc import Iterator
from importlib.metadata import Distribution, PackageNotFoundError, distribution
from pathlib import Path

from packaging.requirements import Requirement

ROOT = Path(__file__).parents[1]
CORE, TEST = ROOT / "requirements.lock", ROOT / "requirements-test.lock"
# Libraries inside wheels that may be had under the GPL or LGPL, and why they may be there.
BUNDLED = {
    "GCC runtime library": "its exception lets any program use it",
    "libquadmath": "a separate shared library, as the LGPL asks",
    "FreeType": "had under its own licence (FTL), the GPL is the other choice",
}
# Packages of tests whose metadata name no licence, and what their licence file says.
READ = {"fmpy": "BSD-2-Clause (its LICENSE.txt)"}
_NAME = re.compile(r"^([A-Za-z0-9][\w.-]*==[^\\\n]+)", re.MULTILINE)
_STANZA = re.compile(r"^Name: (.+)\n(?:.*\n){0,6}?License: (.+)$", re.MULTILINE)
_COPYLEFT = re.compile(r"\b[AL]?GPL|GNU|General Public", re.IGNORECASE)
_WEAK = re.compile(r"\bMPL|Mozilla", re.IGNORECASE)


def locked(lock: Path) -> list[str]:
    """Names of the packages that a lock installs on this machine."""
    rows = (Requirement(row.strip()) for row in _NAME.findall(lock.read_text(encoding="utf-8")))
    return [each.name for each in rows if each.marker is None or each.marker.evaluate()]


def licence(package: Distribution) -> str:
    """What a package says of its own licence; empty where it says nothing.

    Its licence expression, else its classifiers, else the first line of its licence field,
    else what was read in its licence file.
    """
    metadata = package.metadata
    if expression := metadata.get("License-Expression"):
        return expression
    heads = [each.split(" :: ") for each in metadata.get_all("Classifier") or []]
    text = [each[-1] for each in heads if each[0] == "License" and each[-1] != "OSI Approved"]
    field = (metadata.get("License") or "").strip().partition("\n")[0]
    listed = ", ".join(text)
    return listed or field or READ.get((metadata.get("Name") or "").lower(), "")


def copyleft(text: str) -> bool:
    """Whether a licence asks that what uses the package be under it too."""
    return bool(_COPYLEFT.search(text))


def bundled(package: Distribution) -> Iterator[tuple[str, str]]:
    """Name and licence of each library in a wheel that its licence files list with a GPL."""
    for file in package.files or []:
        if ".dist-info/" in str(file) and re.search("LICEN|COPYING", file.name.upper()):
            text = Path(str(file.locate())).read_text(encoding="utf-8", errors="replace")
            yield from (found for found in _STANZA.findall(text) if copyleft(found[1]))


def refused(names: list[str]) -> list[str]:
    """A line for each of these packages that the core must not have."""
    found = []
    for name in names:
        package = distribution(name)
        text = licence(package)
        if copyleft(text) or not text:
            found.append(f"{name}: {text or 'says no licence'}")
        found += [
            f"{name} contains {part}: {its}"
            for part, its in dict(bundled(package)).items()
            if part not in BUNDLED
        ]
    return found


def main() -> int:
    """Print a line a package, what is weakly copyleft, what wheels bundle; 1 where refused."""
    core, every = locked(CORE), dict.fromkeys(locked(CORE) + locked(TEST))
    absent = 0
    for name in sorted(every):
        try:
            package = distribution(name)
        except PackageNotFoundError:
            absent += 1
            continue
        text, part = licence(package), "core" if name in core else "test"
        print(f"{part}  {name + ' ' + package.version:<32} {text}")
        for library, its in dict(bundled(package)).items():
            why = BUNDLED.get(library, "not expected here")
            print(f"{'':6}{'contains ' + library:<32} {its} ({why})")
    if absent:
        print(f"{absent} packages of tests are not installed here: make env-test")
    weak = [name for name in core if _WEAK.search(licence(distribution(name)))]
    print(f"under the MPL in the core: {', '.join(weak) or 'none'}")
    beyond = refused(core)
    print(f"GPL, LGPL, AGPL or unknown in the core: {'; '.join(beyond) or 'none'}")
    return int(bool(beyond))


if __name__ == "__main__":
    sys.exit(main())
