"""Known faults of the locked versions: `python -m tools.advisories`, a part of `make audit`.

pip-audit asks a server for them. Where that is out of reach, or does not know the packages, one
line says so, and the status is 0. Status 1: a locked version has a known fault.
"""

import json
import subprocess
import sys
import venv
from collections.abc import Callable
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[1]
LOCK = ROOT / "requirements-test.lock"  # holds the other lock at the same versions
PLACE = ROOT / ".venv" / "audit"  # pip-audit and what it needs stay apart from the environment
HEAD = "known faults of the locked versions"
Ask = Callable[[], str]


def asked() -> str:
    """pip-audit's answer in JSON, empty where it cannot be installed, or no server answers."""
    tool = PLACE / "bin" / "pip-audit"
    if not tool.exists():
        venv.create(PLACE, with_pip=True)
        words = [str(PLACE / "bin" / "pip"), "install", "--quiet", "pip-audit"]
        if subprocess.run(words, capture_output=True).returncode:
            return ""
    words = [str(tool), "--requirement", str(LOCK), "--require-hashes", "--disable-pip"]
    words += ["--format", "json", "--progress-spinner", "off"]
    return subprocess.run(words, capture_output=True, text=True).stdout


def main(ask: Ask = asked) -> int:
    """Print what is known, or that nothing could be learned; 1 where there is a known fault."""
    try:
        rows: list[dict[str, Any]] = json.loads(ask())["dependencies"]
    except (ValueError, KeyError):
        rows = []
    checked = [row for row in rows if "skip_reason" not in row]
    faults = [(row, each) for row in checked for each in row["vulns"]]
    for row, each in faults:
        mended = ", ".join(each["fix_versions"]) or "no version yet"
        print(f"{row['name']} {row['version']}: {each['id']}, mended in {mended}")
    if not checked:
        print(f"{HEAD}: NOT CHECKED, the server of advisories is out of reach from here")
    elif left := len(rows) - len(checked):
        print(f"{HEAD}: {len(faults)} in {len(checked)}; {left} NOT CHECKED, the server lacks them")
    else:
        print(f"{HEAD}: {len(faults)} in {len(checked)} packages")
    return int(bool(faults))


if __name__ == "__main__":
    sys.exit(main())
