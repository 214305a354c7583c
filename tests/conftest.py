"""What every test has: shapes checked in the library, and a browser for those that look at the page."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import settings
from jaxtyping import install_import_hook
from playwright.sync_api import Browser, sync_playwright

import chromium

REPOSITORY = Path(__file__).parents[1]
LIBRARY = REPOSITORY / "core" / "bspline_slam"
NUMERIC_TOWER = "beartype.beartype(conf=beartype.BeartypeConf(is_pep484_tower=True))"

# Every module of the library has its annotated shapes checked, but the compiled kernels: numba would not see through.
install_import_hook(
    [f"bspline_slam.{entry.stem}" for entry in sorted(LIBRARY.iterdir()) if entry.name != "kernels"], NUMERIC_TOWER
)
settings.register_profile("splinescope", deadline=None, max_examples=60)
settings.load_profile("splinescope")


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    """One headless Chromium for the whole run."""
    path = chromium.find()
    if path is None:
        if os.environ.get("CI") == "true":
            pytest.fail("no browser: `make test` installs one")
        pytest.skip("no browser: `make test` installs one")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, args=chromium.launch_arguments())
        yield browser
        browser.close()
