"""The page of `hannes view` with two grasps: its size, and frames a second while it plays.

A headless Chromium at 1280 x 800 without a graphics processor plays ten seconds (two with
--quick); frames are those that the page itself drew, by its own state.
"""

import shutil
import tempfile
from pathlib import Path

from benchmarks.harness import Row, main, must_show
from hannes import load_experiment, observe, simulate
from hannes.commands.view import view

FLAGS = (
    "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-sync",
    "--disable-background-networking", "--disable-component-update",
)  # fmt: skip
LARGEST, SLOWEST, WISHED = 1e6, 30.0, 60.0  # bytes, frames a second


def measure(quick: bool) -> tuple[list[Row], list[Row]]:
    """Rows of one page, and its bounds."""
    with tempfile.TemporaryDirectory() as folder:
        made = written(Path(folder))
        drawn = played(Path(made["out"]), 2.0 if quick else 10.0)
    rows = [{"page": "two grasps of 1.15 s at 1 kHz", "bytes": made["bytes"], **drawn}]
    rate = drawn["frames_per_s"]
    bounds = [
        must_show("bytes of a page of two grasps", made["bytes"], LARGEST, made["bytes"] < LARGEST),
        must_show("frames a second, two grasps", rate, SLOWEST, rate >= SLOWEST),
        must_show("the same, as wished", rate, WISHED, rate >= 0.98 * WISHED),
    ]
    return rows, bounds


def written(folder: Path) -> dict:
    """The page of two recordings of a grasp, one of a softer object."""
    for name in ("dynamometer", "soft-ball"):
        asked = load_experiment(name)[0]
        observe(asked.hand, simulate(asked.hand, asked.experiment)).to_hdf5(folder / f"{name}.h5")
    files = [folder / f"{name}.h5" for name in ("dynamometer", "soft-ball")]
    return view(files, folder / "view.html")


def played(path: Path, seconds: float) -> dict[str, float]:
    """Frames that the page drew while it played, and the slowest tenth of them."""
    from playwright.sync_api import sync_playwright

    places = filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome")))
    with sync_playwright() as driver:
        running = driver.chromium.launch(executable_path=next(places), args=FLAGS)
        page = running.new_page(viewport={"width": 1280, "height": 800})
        page.goto(path.as_uri())
        while not page.evaluate("Boolean(window.viewer && viewer.ready)"):
            page.wait_for_timeout(20.0)
        page.evaluate("viewer.play()")
        page.wait_for_timeout(500.0)  # the first frames compile the script
        page.evaluate("viewer.frames = 0; viewer.seconds = 0")
        page.wait_for_timeout(1000.0 * seconds)
        frames, spent = page.evaluate("[viewer.frames, viewer.seconds]")
        running.close()
    return {"frames": frames, "seconds": round(spent, 2), "frames_per_s": frames / spent}


if __name__ == "__main__":
    main(__doc__, "viewer", measure)
