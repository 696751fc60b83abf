"""The player in a browser: it plays, steps, picks, follows, measures and saves; by keys too."""

import io
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from read_page import read_page

SILO_AND_DAMPER = pytest.mark.parametrize("name", ["silo_page", "damper_page", "clusters_page"])


@pytest.fixture
def any_page(name, request) -> Path:
    return request.getfixturevalue(name)


def frame(shown) -> int:
    return shown.run("player.state.frame")


def pixels(shown, selector: str = "#stage") -> np.ndarray:
    """Picture (rows, columns, 3) of an element."""
    image = Image.open(io.BytesIO(shown.page.locator(selector).screenshot()))
    return np.asarray(image.convert("RGB")).astype(float)


def stage_of(shown) -> dict:
    """Place and size of the picture of the particles [px]."""
    return shown.page.locator("#stage canvas:not(#legend)").first.bounding_box()


@SILO_AND_DAMPER
def test_numbers_arrive_in_the_browser_as_they_were_packed(any_page, open_page):
    """Each array's sum of values by data.js, and by the tests' own reading of the format."""
    shown = open_page(any_page)
    sums = shown.run(
        "Object.fromEntries(Object.entries(player.arrays).map(([name, array]) =>"
        " [name, array.integers.reduce((sum, integer) => sum + array.value(integer), 0)]))"
    )
    wanted = read_page(any_page.read_text("utf-8")).arrays
    assert set(sums) == set(wanted)
    for name, values in wanted.items():
        scale = np.abs(values).sum() + 1e-300
        assert abs(sums[name] - values.sum()) < 1e-9 * scale, name


@SILO_AND_DAMPER
def test_it_plays_to_the_end_and_begins_again(any_page, open_page):
    """25 frames a second at pace 1, eight times that at the largest; at the end it stops."""
    shown = open_page(any_page)
    frames = shown.run("player.frames")
    shown.page.locator("#play").click()
    shown.shown()
    assert shown.page.locator("#play").get_attribute("aria-label") == "Stop"
    shown.page.locator("#pace").select_option(index=7)
    for _ in range(100):
        if not shown.run("player.state.playing"):
            break
        shown.page.wait_for_timeout(100)
    assert frame(shown) == frames - 1
    before = pixels(shown)
    shown.page.locator("#play").click()
    shown.page.wait_for_timeout(400)
    assert 0 < frame(shown) <= frames - 1
    shown.run("player.play(false)")
    shown.run("player.show(3)")
    shown.shown()
    assert np.abs(pixels(shown) - before).max() > 60


def test_keys_and_buttons_step(silo_page, open_page):
    shown = open_page(silo_page)
    last = shown.run("player.frames") - 1
    press = shown.page.keyboard.press
    steps = [("ArrowRight", 1), ("Shift+ArrowRight", 11), ("ArrowLeft", 10), ("End", last),
             ("ArrowRight", last), ("Home", 0), ("ArrowLeft", 0)]  # fmt: skip
    for key, wanted in steps:
        press(key)
        assert frame(shown) == wanted, key
    for button, wanted in [("last", last), ("back", last - 1), ("on", last), ("first", 0)]:
        shown.page.locator(f"#{button}").click()
        assert frame(shown) == wanted, button
    shown.page.locator("#scrub").fill("7")
    assert frame(shown) == 7
    press("Space")
    assert shown.run("player.state.playing")
    press("Space")
    assert not shown.run("player.state.playing")


def test_every_button_and_field_has_a_name(small_damper_page, open_page):
    """What a screen reader says of each: its label, its title or its text."""
    shown = open_page(small_damper_page)
    nameless = shown.run(
        "[...document.querySelectorAll('button, input, select, canvas, [role]')].filter((node) =>"
        " !(node.hidden || node.ariaLabel || node.ariaHidden || node.labels?.length"
        " || node.textContent.trim() || node.parentElement.id === 'stage'))"
        ".map((node) => node.id || node.outerHTML)"
    )
    assert nameless == []


def test_help_lists_the_keys_and_gives_the_focus_back(silo_page, open_page):
    shown = open_page(silo_page)
    shown.page.keyboard.press("?")
    assert shown.page.locator("#help").is_visible()
    listed = shown.page.locator("#keys").inner_text()
    assert "play or stop" in listed
    assert "contact network" not in listed, "this run has none"
    shown.page.keyboard.press("Escape")
    assert not shown.page.locator("#help").is_visible()
    assert shown.run("document.activeElement.id") == "help-button"


@SILO_AND_DAMPER
def test_a_click_picks_the_particle_that_is_there(any_page, open_page):
    """Ten particles whose centre is seen: what the browser draws there is picked."""
    shown = open_page(any_page)
    shown.run("player.show(5)")
    shown.shown()
    places = shown.run(
        "Array.from({ length: player.data.particles }, (_, k) =>"
        " [k, ...player.view.project(player.view.place(k, 5))])"
    )
    seen = 0
    box = stage_of(shown)
    for particle, x, y, *_ in places[:: max(1, len(places) // 60)]:
        found = shown.run("(at) => player.view.pick(at, 5)", [x, y])
        if found != particle or seen == 10 or not 0 < y < box["height"] - 90:
            continue  # another one is in front of it
        shown.page.mouse.click(box["x"] + x, box["y"] + y)
        assert shown.run("player.state.picked") == particle
        shown.shown()
        assert shown.page.locator("#picked").input_value() == str(particle)
        seen += 1
    assert seen >= 5
    rows = shown.page.locator("#particle").inner_text()
    assert "speed" in rows
    assert "m/s" in rows
    shown.page.keyboard.press("Escape")
    assert shown.run("player.state.picked") == -1


@SILO_AND_DAMPER
def test_a_particle_that_is_followed_stays_in_the_middle(any_page, open_page):
    shown = open_page(any_page)
    shown.page.locator("#picked").fill("3")
    shown.page.locator("#picked").press("Enter")
    shown.page.locator("#follow").check()
    for k in (1, 8, 20):
        shown.run("(k) => player.show(k)", k)
        shown.shown()
        x, y, width, height = shown.run(
            "[...player.view.project(player.view.place(3, player.state.frame)).slice(0, 2),"
            " player.view.width, player.view.height]"
        )
        assert (x, y) == pytest.approx((width / 2, height / 2), abs=0.5)


@SILO_AND_DAMPER
def test_a_distance_is_measured_in_metres(any_page, open_page):
    """Two clicks on the background 120 px apart, over the scale of the picture [px/m]."""
    shown = open_page(any_page)
    shown.page.keyboard.press("m")
    box = stage_of(shown)
    for x in (20, 140):
        shown.page.mouse.click(box["x"] + x, box["y"] + 60)
    shown.shown()
    wanted = 120 / shown.run("player.view.scale")
    points = np.array(shown.run("player.state.points"))
    assert np.linalg.norm(points[1] - points[0]) == pytest.approx(wanted, rel=1e-6)
    words = shown.page.locator("#measured").inner_text()
    assert float(words.split()[1]) == pytest.approx(1e3 * wanted, rel=6e-3)
    assert words.split()[2] == "mm"


@SILO_AND_DAMPER
def test_wheel_and_drag_move_the_view_and_all_is_shown_again(any_page, open_page):
    """Closer at the pointer: the point below it stays there, to the pixel that a wheel counts."""
    shown = open_page(any_page)
    box = stage_of(shown)
    before = shown.run("player.view.unproject([200, 150])")
    scale = shown.run("player.view.scale")
    shown.page.mouse.move(box["x"] + 200, box["y"] + 150)
    shown.page.mouse.wheel(0, -400)
    shown.shown()
    assert shown.run("player.view.scale") == pytest.approx(scale * np.exp(0.6), rel=1e-6)
    after = shown.run("player.view.unproject([200, 150])")
    np.testing.assert_allclose(after, before, atol=1.5 / scale)
    shown.page.mouse.down()
    shown.page.mouse.move(box["x"] + 260, box["y"] + 150, steps=4)
    shown.page.mouse.up()
    assert shown.run("player.state.picked") == -1, "a drag picks nothing"
    shown.page.locator("#fit").click()
    assert shown.run("player.view.scale") == pytest.approx(scale)


@SILO_AND_DAMPER
def test_a_picture_is_saved_with_its_words(any_page, open_page, tmp_path):
    shown = open_page(any_page)
    shown.run("player.show(4)")
    with shown.page.expect_download() as download:
        shown.page.keyboard.press("s")
    path = tmp_path / download.value.suggested_filename
    download.value.save_as(path)
    assert path.name == f"{shown.run('player.data.name')}-4.png"
    image = np.asarray(Image.open(path).convert("RGB")).astype(float)
    stage = pixels(shown)
    assert image.shape[0] > stage.shape[0]
    there = stage[1:-1, 1:-1][60:-100, :800]  # without its border and legend
    middle = image[46 : 46 + stage.shape[0] - 2][60:-100, :800]
    assert np.abs(middle - there).mean() < 3
    assert np.ptp(image[:40, :300]) > 100, "words above"


def test_a_click_on_the_curve_brings_its_frame(silo_page, open_page):
    shown = open_page(silo_page)
    box = shown.page.locator("#curves").bounding_box()
    times = shown.run("[player.time.at(0), player.time.at(player.frames - 1)]")
    for part in (0.25, 0.8):
        first, last = shown.run("player.curves.span(player.time.at(player.state.frame))")
        x = 58 + part * (box["width"] - 68)
        shown.page.mouse.click(box["x"] + x, box["y"] + 50)
        wanted = min(first + part * (last - first), times[1])
        assert shown.run("player.time.at(player.state.frame)") == pytest.approx(wanted, abs=6e-3)
