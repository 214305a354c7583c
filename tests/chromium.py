"""A Chromium for the tests of the page: an installed one, else Playwright's own, else the Debian package.

Run as a script it prints where the browser is, and installs one first when there is none.
"""

from __future__ import annotations

import logging
import os
import shutil
import subprocess
import sys
from pathlib import Path

from playwright.sync_api import Error, sync_playwright

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome")
log = logging.getLogger(__name__)


def launch_arguments() -> list[str]:
    """No GPU and no talk with the outside; and Chromium refuses to run as root inside its sandbox."""
    quiet = ["gpu", "quic", "background-networking", "component-update", "sync"]
    sandbox = ["--no-sandbox"] if os.geteuid() == 0 else []
    return [*(f"--disable-{what}" for what in quiet), "--no-first-run", *sandbox]


def installed() -> Path | None:
    """A browser of the system that starts."""
    found = (shutil.which(name) for name in NAMES)
    return next((Path(path) for path in found if path and starts(Path(path))), None)


def playwrights_own() -> Path | None:
    """The browser that Playwright downloaded, if it is there and starts."""
    with sync_playwright() as playwright:
        path = Path(playwright.chromium.executable_path)
    return path if path.exists() and starts(path) else None


def starts(path: Path) -> bool:
    """Whether this browser runs here; a downloaded one may lack libraries of the system."""
    try:
        with sync_playwright() as playwright:
            playwright.chromium.launch(executable_path=path, args=launch_arguments()).close()
    except Error:
        return False
    return True


def find() -> Path | None:
    """The browser that the tests use, None when there is none yet."""
    return installed() or playwrights_own()


def install() -> Path:
    """Fetch a browser: Playwright's own build, else (as root) the package of the distribution."""
    attempts = [[sys.executable, "-m", "playwright", "install", "chromium"]]
    if os.geteuid() == 0 and shutil.which("apt-get"):
        attempts += [["apt-get", "update"], ["apt-get", "install", "--yes", "--no-install-recommends", "chromium"]]
    for command in attempts:
        log.info("No browser yet, trying: %s", " ".join(command))
        subprocess.run(command, check=False)
        if path := find():
            return path
    raise SystemExit("The tests of the page need a browser: install Chromium or Chrome and run them again.")


if __name__ == "__main__":
    logging.basicConfig(level=logging.INFO, format="%(message)s")
    log.info("Browser for the tests: %s", find() or install())
