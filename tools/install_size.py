"""Size and time of the core install: `python -m tools.install_size`.

Installs requirements.lock and hannes into a fresh environment in a temporary folder, packages
downloaded anew, and prints what it took.
"""

import subprocess
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

ROOT = Path(__file__).parents[1]
LARGEST = 8  # packages that are named
PROJECT = ["--no-deps", "--no-build-isolation", str(ROOT)]


def timed(*command: str) -> float:
    """Run a command and return the seconds it took; its own words only where it fails."""
    start = time.perf_counter()
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        sys.exit(f"{' '.join(command)}\n{done.stdout}{done.stderr}")
    return time.perf_counter() - start


def sizes(packages: Path) -> Counter[str]:
    """MB on disk by folder of site-packages, with the libraries beside each (`numpy.libs`)."""
    found: Counter[str] = Counter()
    for path in packages.rglob("*"):
        if path.is_file():
            found[path.relative_to(packages).parts[0].removesuffix(".libs")] += path.stat().st_size
    return Counter({name: size / 1e6 for name, size in found.items()})


def main() -> None:
    """Install, weigh and print."""
    with tempfile.TemporaryDirectory() as folder:
        python = str(Path(folder) / "bin" / "python")
        install = (python, "-m", "pip", "install", "--quiet", "--no-cache-dir")
        took = timed(sys.executable, "-m", "venv", folder)
        took += timed(*install, "-r", str(ROOT / "requirements.lock"))
        took += timed(*install, *PROJECT)
        first = timed(python, "-m", "hannes", "--help")
        (packages,) = Path(folder).glob("lib/python*/site-packages")
        found = sizes(packages)
    print(f"core install: {sum(found.values()):.0f} MB, {took:.0f} s with its downloads")
    print(f"hannes --help, the first time: {first:.1f} s")
    for name, size in found.most_common(LARGEST):
        print(f"  {size:5.0f} MB  {name}")


if __name__ == "__main__":
    main()
