"""Chromium, as Debian installs it, and pages in it; what a page says and asks for is kept.

These tests are marked `browser` and skipped where there is no Chromium (make browse runs them).
"""

import shutil
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest
from fake_damper_run import write_fake_damper_run
from fake_run import write_fake_run

from granulab.campaign.runs.folder import RunFolder

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
ARGUMENTS = [
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync",
]  # fmt: skip
MOST = 2.5e6  # bytes of a page
_HERE = Path(__file__).parent


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark the tests of this folder, and skip them where they cannot be done."""
    reason = None if CHROMIUM else "no chromium on this machine (Debian: apt-get install chromium)"
    try:
        import playwright  # noqa: F401
    except ImportError:
        reason = "no playwright: pip install granulab[tests]"
    for item in items:
        if _HERE in item.path.parents:
            item.add_marker(pytest.mark.browser)
            if reason:
                item.add_marker(pytest.mark.skip(reason=reason))


@dataclass
class Shown:
    """A page in the browser, what it reported and what it asked the network for."""

    page: Any
    errors: list[str] = field(default_factory=list)
    requests: list[str] = field(default_factory=list)

    def run(self, script: str, argument: Any = None) -> Any:
        """Value of an expression, or of a function of one argument, in the page."""
        return self.page.evaluate(script, argument)

    def shown(self, script: str = "") -> Any:
        """The value of a script once the next picture is drawn."""
        return self.run(
            f"async () => {{ {script or ''}; for (let k = 0; k < 3; k++)"
            " await new Promise((done) => requestAnimationFrame(done)); }"
        )


@pytest.fixture(scope="session")
def chromium() -> Iterator[Any]:
    """The browser, without a network of its own."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=ARGUMENTS)
        yield browser
        browser.close()


@pytest.fixture
def open_page(chromium) -> Iterator[Any]:
    """Opens a file in a window; at the end no page may have had an error or asked for anything."""
    contexts, pages = [], []

    def opened(
        path: Path, *, size: tuple[int, int] = (1200, 800), scheme: str = "light", before: str = "",
        ready: str = "player",
    ) -> Shown:  # fmt: skip
        context = chromium.new_context(
            viewport={"width": size[0], "height": size[1]}, color_scheme=scheme, offline=True,
            accept_downloads=True,
        )  # fmt: skip
        contexts.append(context)
        shown = Shown(context.new_page())
        pages.append(shown)
        if before:
            shown.page.add_init_script(before)
        shown.page.on("pageerror", lambda error: shown.errors.append(str(error)))
        shown.page.on(
            "console",
            lambda said: shown.errors.append(said.text) if said.type == "error" else None,
        )
        shown.page.on("request", lambda request: shown.requests.append(request.url))
        shown.page.goto(path.resolve().as_uri())
        for _ in range(100):
            if shown.run(f"typeof {ready} !== 'undefined'"):
                break
            shown.page.wait_for_timeout(50)
        if shown.run(f"typeof {ready} !== 'undefined'"):
            shown.shown()
        return shown

    yield opened
    for context in contexts:
        context.close()
    for one in pages:
        assert one.errors == []
        left = [url for url in one.requests if not url.startswith(("file:", "data:", "blob:"))]
        assert left == []


@pytest.fixture
def opened(chromium) -> Iterator[Any]:
    """Opens an address in a window; at the end no page may have had an error, or left that address.

    What a page may ask for is what begins with its address, data and blobs.
    """
    contexts: list[Any] = []
    faults: list[str] = []

    def show(address: str, *, width: int = 1440, height: int = 900, scheme: str = "light") -> Any:
        context = chromium.new_context(
            viewport={"width": width, "height": height}, color_scheme=scheme
        )
        contexts.append(context)
        page = context.new_page()
        page.set_default_timeout(60_000)

        def asked(request: Any) -> None:
            if not request.url.startswith((address, "data:", "blob:")):
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


def _page(folder: Path, run: RunFolder, player_page: Any) -> Path:
    path = folder / f"{run.path.name}.html"
    path.write_text(player_page(run.path, MOST)[0], encoding="utf-8")
    return path


@pytest.fixture(scope="session")
def silo_page(tmp_path_factory) -> Path:
    """The page of a made discharge of A4, without contacts: the same on every machine."""
    from silo2d.view.player import player_page

    folder = tmp_path_factory.mktemp("silo-page")
    return _page(folder, write_fake_run(folder / "made", spacing=0.02), player_page)


@pytest.fixture(scope="session")
def small_silo_page(reference, tmp_path_factory) -> Path:
    """The page of the small silo that was simulated, with its contacts."""
    from silo2d.view.player import player_page

    return _page(tmp_path_factory.mktemp("small-silo-page"), reference, player_page)


@pytest.fixture(scope="session")
def damper_page(tmp_path_factory) -> Path:
    """The page of a made bed of spheres: the same on every machine."""
    from damper3d.view.player.page import player_page

    folder = tmp_path_factory.mktemp("damper-page")
    return _page(folder, write_fake_damper_run(folder / "made"), player_page)


@pytest.fixture(scope="session")
def clusters_page(tmp_path_factory) -> Path:
    """The same of particles of three spheres."""
    from damper3d.view.player.page import player_page

    folder = tmp_path_factory.mktemp("clusters-page")
    return _page(folder, write_fake_damper_run(folder / "made", clusters=True), player_page)


@pytest.fixture(scope="session")
def mixture_page(tmp_path_factory) -> Path:
    """The same of a mixture: half of them of three spheres, half of two, in two sizes."""
    from damper3d.view.player.page import player_page

    folder = tmp_path_factory.mktemp("mixture-page")
    run = write_fake_damper_run(folder / "made", clusters=True, unlike=True)
    return _page(folder, run, player_page)


@pytest.fixture(scope="session")
def small_damper_page(damper_reference, tmp_path_factory) -> Path:
    """The page of the small damper that was simulated, with its contacts."""
    from damper3d.view.player.page import player_page

    return _page(tmp_path_factory.mktemp("small-damper-page"), damper_reference, player_page)
