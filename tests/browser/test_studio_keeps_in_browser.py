"""The studio in a browser keeps what was written, and says what goes on elsewhere."""

import pytest
from small_silo import SHAPES
from studio_page import click_at, expect, open_case
from studio_server import Studio

from silo2d.case.case import SiloCase
from silo2d.run.sweep import SILO

IN_CM = """schema = 1
[silo]
outline = [[-10, 0], [10, 0], [10, 50], [-10, 50]]
outline_unit = "cm"
outlet = "100 mm"
"""


@pytest.fixture(scope="module")
def studio(tmp_path_factory):
    folder = tmp_path_factory.mktemp("studio")
    (folder / "in_cm.toml").write_text(IN_CM)
    (folder / "stones.toml").write_text(SHAPES)
    running = Studio(folder)
    running.ask("start")  # it reads the simulators in, which takes longer than a page is waited for
    yield running
    code, err = running.close()
    assert (code, err.count("\n")) == (0, 1), err


@pytest.fixture
def begun(studio):
    """The folder of a run of A4 that was begun."""
    case = SiloCase.load("A4")
    run = SILO.run_folder(case, studio.folder / "runs")
    run.path.mkdir(parents=True, exist_ok=True)
    run.write_case(case.to_toml())
    return run


@pytest.fixture
def faulty(chromium, studio):
    """A page whose requests fail in a test."""
    context = chromium.new_context()
    page = context.new_page()
    page.goto(studio.address)
    yield page
    context.close()


def outline_of(page):
    return page.get_by_label("outline", exact=True)


def run_button(page):
    return page.locator("button.run")


def test_an_outline_keeps_its_unit(studio, opened):
    """A grid of 10 mm is one of 1 cm: the corner is set 1 cm below the last one."""
    page = opened(studio.address)
    open_case(page, "in_cm.toml")
    expect(page.locator(".fine")).to_be_visible()
    page.get_by_role("button", name="Draw the outline").click()
    page.locator(".drawing canvas").focus()
    page.keyboard.press("ArrowDown")
    page.keyboard.press("Enter")
    expect(outline_of(page)).to_have_value("[[-10, 0], [10, 0], [10, 50], [-10, 50], [-10, 49]]")
    expect(page.get_by_label("outline_unit")).to_have_value("cm")
    expect(page.locator(".fine")).to_be_visible()


def test_undo_restores_what_clear_removed_and_crosses_no_case(studio, opened):
    page = opened(studio.address)
    preset = page.get_by_label("preset", exact=True)
    page.get_by_role("button", name="Clear").click()
    expect(preset).to_have_value("")
    page.get_by_role("button", name="Undo").click()
    expect(preset).to_have_value("A4")
    expect(outline_of(page)).to_have_value("")
    page.get_by_role("button", name="Clear").click()
    open_case(page, "B4")
    page.get_by_role("button", name="Open the other").click()
    expect(preset).to_have_value("B4")
    page.get_by_role("button", name="Undo").click()
    expect(preset).to_have_value("B4")


def test_corners_may_be_as_near_as_the_grid(studio, opened):
    """Corners 5 mm apart, some pixels."""
    page = opened(studio.address)
    page.get_by_role("button", name="Clear").click()
    page.get_by_label("Grid").select_option("5")
    corners = [(0, 0), (5, 0), (5, 5), (0, 5)]
    click_at(page, [*corners, corners[0]])
    expect(outline_of(page)).to_have_value("[[0, 0], [5, 0], [5, 5], [0, 5]]")
    drawn = page.locator(".drawing canvas").evaluate("(one) => [one.width, one.clientWidth]")
    assert drawn[0] == drawn[1], "a pixel of the picture is one of the pointer"


def test_nothing_runs_before_its_texts_are_checked(studio, opened):
    """One question at a time; the answer that is waited for is that to the newest texts."""
    page, held = opened(studio.address), []
    expect(run_button(page)).to_be_enabled()
    page.route("**/api/check", lambda route: held.append(route))
    level = page.get_by_label("level [m]")
    level.fill("300 mm")
    expect(run_button(page)).to_be_disabled()
    expect(page.locator(".said")).to_contain_text("checking ...")
    page.wait_for_timeout(600)
    level.fill("310 mm")
    page.wait_for_timeout(600)
    assert len(held) == 1
    with page.expect_request("**/api/check") as asked:
        held[0].continue_()
    assert "310 mm" in asked.value.post_data
    expect(run_button(page)).to_be_disabled()
    page.wait_for_timeout(100)
    held[1].continue_()
    expect(run_button(page)).to_be_enabled()


def test_too_many_particles_to_draw_are_said_to_be(studio, opened):
    page = opened(studio.address)
    expect(page.locator(".fine")).to_be_visible()
    expect(page.get_by_text("too many to draw")).to_be_hidden()
    page.get_by_label("scale", exact=True).fill("0.15")
    expect(page.get_by_text("too many to draw")).to_be_visible()


def test_a_draft_survives_reload_back_and_the_list(studio, opened):
    page = opened(studio.address)
    name, files = page.get_by_label("Name of the case"), page.get_by_label("Open a case")
    name.fill("mine")
    files.focus()
    page.keyboard.press("ArrowDown")
    for _ in range(2):
        page.reload()
        expect(name).to_have_value("mine")
    page.get_by_role("tab", name="Damper").click()
    page.go_back()
    expect(name).to_have_value("mine")
    expect(page.get_by_role("tab", name="Silo")).to_have_attribute("aria-selected", "true")
    open_case(page, "B4")
    page.get_by_role("dialog").get_by_role("button", name="Cancel").click()
    expect(name).to_have_value("mine")


def test_tabs_move_by_arrow_keys_and_lists_take_new_files(studio, opened):
    page = opened(studio.address)
    files = page.get_by_label("Open a case")
    expect(files).to_contain_text("in_cm.toml")
    (studio.folder / "new.toml").write_text(IN_CM)
    assert "new.toml" not in files.text_content()
    files.focus()
    expect(files).to_contain_text("new.toml")
    expect(page.get_by_label("Shapes from the catalogue")).to_contain_text("new.toml")
    page.get_by_role("tab", name="Silo").focus()
    page.keyboard.press("ArrowRight")
    expect(page.get_by_role("tab", name="Damper")).to_have_attribute("aria-selected", "true")
    expect(page.get_by_label("Name of the case")).to_have_value("damper")


def test_a_run_of_another_program_is_watched(studio, opened, begun):
    page, name = opened(studio.address), begun.path.name
    page.get_by_label("Name of the case").fill("A4")
    expect(page.get_by_role("button", name="Go on with its run")).to_be_enabled()
    with begun.lock():
        page.get_by_role("tab", name="Runs").click()
        page.get_by_role("tab", name="Silo").click()
        page.get_by_role("button", name="Watch its run").click()
        expect(page.locator(".run")).to_contain_text("runs in another program")
        assert page.url.endswith(f"#runs/{name}")
        page.reload()
        expect(page.locator(".run h2")).to_have_text(name)
        expect(page.locator(".run")).to_contain_text("runs in another program")
        expect(page.get_by_role("button", name="Go on")).to_be_hidden()
    expect(page.get_by_role("button", name="Go on")).to_be_visible()


def test_a_lost_answer_leaves_nothing_behind(faulty, begun):
    page = faulty
    page.get_by_role("tab", name="Runs").click()
    page.route("**/api/run?*", lambda route: route.abort(), times=1)
    page.get_by_role("button", name=begun.path.name).click()
    expect(page.locator(".run .refused")).to_contain_text("is it still running?")
    expect(page.locator(".run .refused")).to_be_hidden()


def test_a_studio_that_was_restarted_is_said_to_be(faulty):
    """A server with another token answers nothing but 404."""
    page = faulty
    page.route("**/api/check", lambda route: route.fulfill(status=404, body="Nothing here"))
    page.get_by_label("level [m]").fill("300 mm")
    expect(page.locator(".refused")).to_have_text(
        "the studio was restarted; open the address that its terminal shows"
    )


def draw_with_keys(page, *ways):
    """Corners by keys: each a word of arrows, of 1 mm, or of 10 mm in capitals."""
    page.get_by_role("dialog").locator("canvas").focus()
    for way in ways:
        for letter in way:
            arrow = {"r": "Right", "l": "Left", "u": "Up", "d": "Down"}[letter.lower()]
            page.keyboard.press(f"{'Shift+' * letter.isupper()}Arrow{arrow}")
        page.keyboard.press("Enter")


def test_shapes_that_are_drawn_are_removed_refused_and_asked_for(studio, opened):
    page = opened(studio.address)
    page.get_by_role("button", name="Draw", exact=True).click()
    dialog = page.get_by_role("dialog", name="Draw particles")
    add, shapes = dialog.get_by_role("button", name="Add this shape"), dialog.locator("li")
    draw_with_keys(page, "r", "R", "U", "L", "D")
    add.click()
    expect(shapes).to_have_count(1)
    draw_with_keys(page, "r", "R", "Lrruu", "lluuuuuuuu", "D")
    add.click()
    expect(dialog.locator(".refused")).to_contain_text("concave")
    expect(shapes).to_have_count(1)
    dialog.get_by_role("button", name="Leave out shape 1").click()
    expect(shapes).to_have_count(0)
    question = page.get_by_role("dialog").filter(has_text="drawn here are not saved").last
    page.keyboard.press("Escape")
    question.get_by_role("button", name="Cancel").click()
    expect(dialog).to_be_visible()
    dialog.get_by_role("button", name="Close").focus()
    page.keyboard.press("Escape")
    question.get_by_role("button", name="Close").click()
    expect(dialog).to_be_hidden()
