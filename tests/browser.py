"""A headless Chromium for tests of pages: the distribution's, driven through playwright."""

import shutil
import time
from contextlib import contextmanager

import pytest

FLAGS = (
    "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-sync",
    "--disable-background-networking", "--disable-component-update",
)  # fmt: skip
PLACES = ("chromium", "chromium-browser", "google-chrome")


def chromium():
    """Path of the browser; the test is skipped where it or its driver is absent."""
    pytest.importorskip("playwright", reason="pip install playwright drives the browser")
    path = next(filter(None, map(shutil.which, PLACES)), None)
    if path is None:
        pytest.skip("no Chromium on this machine: apt-get install chromium")
    return path


@contextmanager
def browser():
    """A running browser."""
    path = chromium()
    from playwright.sync_api import sync_playwright

    with sync_playwright() as driver:
        running = driver.chromium.launch(executable_path=path, args=FLAGS)
        try:
            yield running
        finally:
            running.close()


def opened(running, path, width=1280, height=800):
    """A page and the list into which its messages, errors and requests for other pages go."""
    page, messages = running.new_page(viewport={"width": width, "height": height}), []
    page.on("console", lambda each: messages.append(each.text))
    page.on("pageerror", lambda each: messages.append(str(each)))
    page.on(
        "request",
        lambda each: each.url.startswith(("file:", "data:", "blob:")) or messages.append(each.url),
    )
    page.goto(path.resolve().as_uri())
    return page, messages


def until(page, expression, seconds=20.0):
    """Wait until an expression holds; from outside, for a page's own policy may forbid `eval`."""
    end = time.monotonic() + seconds
    while not page.evaluate(expression):
        assert time.monotonic() < end, f"{expression} did not come true in {seconds} s"
        page.wait_for_timeout(20)
