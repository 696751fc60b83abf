"""The silo's room of the studio in a browser: what tests do there."""

from typing import Any

# The plane that is shown where nothing is drawn yet [m], and the margin round it [px]
# (granulab/studio/page/silo.js, plane.js).
LEFT, RIGHT, BOTTOM, TOP = -0.3, 0.3, -0.05, 0.6
MARGIN = 18


def click_at(page: Any, corners: Any) -> None:
    """Click places of the silo's plane [mm]."""
    box = page.locator(".drawing canvas").bounding_box()
    width, height = box["width"], box["height"]
    scale = min((width - 2 * MARGIN) / (RIGHT - LEFT), (height - 2 * MARGIN) / (TOP - BOTTOM))
    for x, y in corners:
        px = box["x"] + width / 2 + (1e-3 * x - (LEFT + RIGHT) / 2) * scale
        py = box["y"] + height / 2 - (1e-3 * y - (BOTTOM + TOP) / 2) * scale
        page.mouse.move(px, py)
        page.mouse.down()
        page.mouse.up()


def expect(locator: Any) -> Any:
    """Assertions on what is in a page, which wait."""
    from playwright.sync_api import expect as expecting

    return expecting(locator)


def open_case(page: Any, name: str) -> None:
    """Choose a case in the list, and open it."""
    page.get_by_label("Open a case").select_option(name)
    page.get_by_role("button", name="Open", exact=True).click()
