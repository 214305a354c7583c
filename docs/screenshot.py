"""Make docs/screenshot.png anew: the office, its map, one scan with its associations, and what can be asked of it."""

from __future__ import annotations

import tempfile
from pathlib import Path

from playwright.sync_api import Page, sync_playwright

import chromium
from splinescope import commands as ask
from splinescope.api import Workbench, open_workbench
from splinescope.browser.preferences import Preferences, save

PICTURE = Path(__file__).with_name("screenshot.png")
SCAN = 651
SIZE = {"width": 1600, "height": 900}
SEEN = "window.splinescope?.camera?.viewport() && splinescope.latest.get('tab') !== undefined"


def main() -> None:
    """Let the sample be processed, open the page, and take the picture once it stands still."""
    with tempfile.TemporaryDirectory() as memory:
        session = Path(memory) / "session.json"
        save(Preferences(toured=True), session)
        path, arguments = chromium.find(), chromium.launch_arguments()
        with open_workbench("office", browser=False, session=session) as scope, sync_playwright() as playwright:
            scope.wait()
            browser = playwright.chromium.launch(executable_path=path, args=arguments)
            photograph(browser.new_page(viewport=SIZE), scope)
            browser.close()


def photograph(page: Page, scope: Workbench) -> None:
    page.goto(scope.url)
    page.wait_for_function(SEEN)
    page.get_by_role("tab", name="Edit", exact=True).click()
    scope.do(ask.Seek(SCAN))
    page.keyboard.press("j")
    page.keyboard.press("f")
    page.mouse.move(5, 5)
    page.wait_for_timeout(8_000)  # until notices have gone and the map stands still
    page.screenshot(path=PICTURE)


if __name__ == "__main__":
    main()
