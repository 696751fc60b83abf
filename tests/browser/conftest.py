"""Pages in a real browser: Debian's Chromium, driven by Playwright, with nothing else reached.

Each test here is of the marker `browser`; where there is no Chromium, or no Playwright, it is
skipped with the reason.
"""

import os
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

_CHROMIUM = os.environ.get("CHROMIUM", "/usr/bin/chromium")
_QUIET = [
    "--no-sandbox",
    *(
        f"--disable-{what}"
        for what in ("gpu", "quic", "background-networking", "component-update", "sync")
    ),
    "--no-first-run",
]


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark the tests of this folder."""
    for item in items:
        if Path(__file__).parent in item.path.parents:
            item.add_marker(pytest.mark.browser)


@pytest.fixture(scope="session")
def chromium() -> Iterator[Any]:
    """The browser, with a profile of its own."""
    path = shutil.which(_CHROMIUM)
    if path is None:
        pytest.skip(f"no Chromium at {_CHROMIUM}; install it, or name one in CHROMIUM")
    sync_api = pytest.importorskip("playwright.sync_api", reason="Playwright drives the browser")
    with sync_api.sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, headless=True, args=_QUIET)
        yield browser
        browser.close()


@pytest.fixture
def opened(chromium: Any) -> Iterator[Callable[..., Any]]:
    """Opens an address in a page of a width, light or dark.

    At the end of the test no page may have had an error on its console, or a request for anything
    but what `own` begins (the address, unless given), data and blobs.
    """
    contexts: list[Any] = []
    faults: list[str] = []

    def show(
        address: str, *, width: int = 1440, height: int = 900, dark: bool = False, own: str = ""
    ) -> Any:
        scheme = "dark" if dark else "light"
        context = chromium.new_context(
            viewport={"width": width, "height": height}, color_scheme=scheme
        )
        contexts.append(context)
        page = context.new_page()
        page.set_default_timeout(60_000)

        def asked(request: Any) -> None:
            if not request.url.startswith((own or address, "data:", "blob:")):
                faults.append(f"request: {request.url}")

        def said(message: Any) -> None:
            if message.type == "error":
                faults.append(f"console: {message.text}")

        page.on("request", asked)
        page.on("console", said)
        page.on("pageerror", lambda error: faults.append(f"script: {error}"))
        page.goto(address)
        return page

    yield show
    for context in contexts:
        context.close()
    assert faults == []
