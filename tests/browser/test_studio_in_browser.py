"""The studio in a browser: built by mouse, refused, run, stopped, gone on with, opened again."""

import re
import shutil
import tomllib
from pathlib import Path

import pytest
from made_drawings import A4_DOWN, photograph, regular, svg, svg_path
from small_silo import SHAPES
from studio_page import click_at, expect, open_case
from studio_server import Studio

from granulab.campaign.runs.folder import RunFolder
from silo2d.case.case import SiloCase
from silo2d.case.shapefile import load_shapes
from silo2d.run.sweep import SILO

MEDIA = Path(__file__).parents[2] / "data" / "media"


@pytest.fixture(scope="module")
def studio(tmp_path_factory):
    folder = tmp_path_factory.mktemp("studio")
    (folder / "small.toml").write_text(SHAPES)
    running = Studio(folder)
    yield running
    code, err = running.close()
    assert (code, err.count("\n")) == (0, 1), err


OUTLINE = [(-30, 0), (30, 0), (40, 20), (40, 90), (-40, 90), (-40, 20)]


def draw_small_silo(page, name):
    """Draw the outline by mouse, and write what else the small silo needs."""
    page.get_by_role("button", name="Clear").click()
    click_at(page, [*OUTLINE, OUTLINE[0]])
    page.get_by_label("Name of the case").fill(name)
    page.get_by_label("shapes", exact=True).fill("small.toml")
    page.get_by_label("level [m]").fill("50 mm")


def test_a_silo_is_drawn_by_mouse_refused_run_and_opened_again_with_its_digest(studio, opened):
    page = opened(studio.address)
    draw_small_silo(page, "drawn")
    expect(page.locator(".toml")).to_contain_text("outline")  # no longer the preset's, also fine
    expect(page.locator(".fine")).to_contain_text("nothing is refused")
    assert tomllib.loads(page.locator(".toml").text_content())["silo"] == {
        "outline": [list(corner) for corner in OUTLINE]
    }

    page.get_by_label("level [m]").fill("200 mm")  # above the rim
    expect(page.locator(".refused")).to_have_text(
        "drawn.toml: [fill] level = 200 mm: must be above the largest particle, 10.8 mm, and at "
        "most the silo's height, 90 mm"
    )
    expect(page.get_by_role("button", name="Run", exact=True)).to_be_disabled()
    page.get_by_label("level [m]").fill("50 mm")

    page.locator("summary", has_text="[law]").click()
    page.get_by_label("kn [N/m]").fill("1e3 N/mm")
    page.get_by_label("keep_ratios").select_option("true")
    page.locator("summary", has_text="[run]").click()
    page.get_by_label("max_time").fill("0.3 s")
    page.get_by_label("with pictures and film").uncheck()
    expect(page.locator(".fine")).to_be_visible()
    digest = page.locator(".digest").text_content()
    page.get_by_role("button", name="Run", exact=True).click()

    expect(page.locator(".run h2")).to_contain_text("drawn-seed1-")
    expect(page.locator(".report")).to_contain_text("particles out", timeout=120_000)
    expect(page.locator(".report")).to_have_css("white-space", "pre-wrap")
    run = page.locator(".run h2").text_content()
    assert run in digest
    of_file = SiloCase.load(studio.folder / "drawn.toml")
    folder = SILO.run_folder(of_file, studio.folder / "runs")
    assert (folder.path.name, folder.state) == (run, "finished"), "the command takes the same run"

    page.get_by_role("tab", name="Silo").click()
    open_case(page, "A1")
    expect(page.locator(".digest")).to_contain_text("A1-seed1-")
    open_case(page, "drawn.toml")
    expect(page.locator(".digest")).to_have_text(digest)
    expect(page.get_by_role("button", name="Show its run")).to_be_visible()


def test_a_run_is_watched_stopped_and_gone_on_with(studio, opened):
    page = opened(studio.address)
    draw_small_silo(page, "watched")
    page.locator("summary", has_text="[run]").click()
    page.get_by_label("time_step [s]").first.fill("0.1 us")  # some seconds to be stopped in
    page.get_by_label("with pictures and film").uncheck()
    page.get_by_role("button", name="Run", exact=True).click()
    expect(page.locator(".watch p")).to_contain_text("out", timeout=120_000)  # a frame is there
    drawn = page.locator(".watch canvas").screenshot()
    assert len(set(drawn)) > 100, "a picture, not an empty one"
    page.get_by_role("button", name="Stop").click()
    expect(page.get_by_role("button", name="Go on")).to_be_visible()
    expect(page.locator(".run")).to_contain_text("stopped; its state is kept")
    run = page.locator(".run h2").text_content()
    assert RunFolder(studio.folder / "runs" / run).state == "unfinished"
    page.get_by_role("button", name="Go on").click()
    expect(page.locator(".report")).to_contain_text("particles out", timeout=180_000)
    page.locator("summary", has_text="Play it").click()
    player = page.frame_locator("iframe")
    expect(player.locator("#clock")).to_contain_text("s")


def test_an_outline_is_drawn_with_the_keys_alone(studio, opened):
    page = opened(studio.address)
    page.get_by_role("button", name="Clear").click()
    page.locator(".drawing canvas").focus()
    for key in ["ArrowLeft", "Enter", *["ArrowRight"] * 3, "Enter", "Shift+ArrowUp", "Enter",
                *["ArrowLeft"] * 3, "Enter", "Shift+ArrowDown", "Enter"]:  # fmt: skip
        page.keyboard.press(key)
    expect(page.get_by_label("outline", exact=True)).to_have_value(
        "[[-10, 0], [20, 0], [20, 100], [-10, 100]]"
    )
    page.keyboard.press("Control+z")
    page.keyboard.press("Delete")
    expect(page.get_by_label("outline", exact=True)).to_have_value(  # the corner at the cursor went
        "[[20, 0], [20, 100], [-10, 100]]"
    )


def test_a_drawing_is_imported(studio, opened):
    page = opened(studio.address)
    drawing = {"name": "a4.svg", "mimeType": "image/svg+xml",
               "buffer": svg(svg_path(A4_DOWN)).encode()}  # fmt: skip
    page.locator(".drawing input[type=file]").set_input_files(drawing)
    expect(page.locator(".fine")).to_contain_text("About 605 particles")
    unitless = {**drawing, "name": "b.svg", "buffer": svg(svg_path(A4_DOWN), "300").encode()}
    page.locator(".drawing input[type=file]").set_input_files(unitless)
    expect(page.locator(".refused")).to_contain_text("b.svg: does not say its unit of length")


def test_particles_come_from_a_photograph(studio, opened, tmp_path):
    true = [regular(5 + k % 2, 70, (120 + 230 * k, 150)) for k in range(3)]
    picture = photograph(tmp_path / "stones.png", true, (500, 500, 700, 512))
    page = opened(studio.address)
    page.get_by_role("button", name="From a photograph or drawing").click()
    dialog = page.get_by_role("dialog")
    dialog.locator("input[type=file]").set_input_files(picture)
    dialog.get_by_label("Length of the scale bar").fill("20 mm")
    dialog.get_by_label("Length of the scale bar").blur()
    expect(dialog.locator("pre")).to_contain_text("3 particles")
    dialog.get_by_role("button", name="Save and use").click()
    expect(page.get_by_label("shapes", exact=True)).to_have_value("stones.toml")
    expect(page.locator(".fine")).to_be_visible()
    assert len(load_shapes(studio.folder / "stones.toml").shapes) == 3


def test_a_damper_is_shown_as_its_filling_begins(studio, opened):
    page = opened(studio.address)
    page.get_by_role("tab", name="Damper").click()
    page.get_by_label("count").fill("60")
    expect(page.locator(".drawing p")).to_contain_text("as they are let go", timeout=120_000)
    page.get_by_label("diameter [m]", exact=True).fill("4 mm")
    expect(page.locator(".refused")).to_be_visible()
    expect(page.locator(".stage.stale")).to_be_visible()  # the picture is not of this case
    page.get_by_label("diameter [m]", exact=True).fill("40 mm")
    open_case(page, "host")
    page.get_by_role("button", name="Open the other").click()
    expect(page.locator(".said")).to_contain_text("host")


def test_a_film_is_measured_in_a_region_and_its_value_written(studio, opened):
    page = opened(studio.address)
    page.get_by_role("tab", name="Laboratory").click()
    page.locator(".drop input").set_input_files(MEDIA / "drop.mp4")
    page.locator("summary", has_text="Part of the picture").click()
    canvas = page.locator(".picture canvas")
    expect(page.locator(".picture img")).to_have_js_property("naturalWidth", 160)
    box = canvas.bounding_box()
    page.mouse.move(box["x"] + 10, box["y"] + 2)
    page.mouse.down()
    page.mouse.move(box["x"] + 150, box["y"] + 318, steps=3)
    page.mouse.up()
    expect(page.get_by_label("roi")).to_have_value("10,2,140,316")
    page.locator("summary", has_text="Write the value").click()
    page.get_by_label("into").fill("mine.toml")
    page.get_by_label("pair").fill("wood-steel")
    page.get_by_role("button", name="Measure and write").click()
    expect(page.locator(".answer")).to_contain_text("restitution 0.75", timeout=120_000)
    expect(page.locator(".figures img").first).to_be_visible()
    table = tomllib.loads((studio.folder / "mine.toml").read_text())
    # the film is rendered with 0.75
    assert table["pair"]["wood-steel"]["restitution"]["value"] == pytest.approx(0.75, abs=2e-3)
    page.get_by_label("pair").fill("wood")
    page.get_by_role("button", name="Measure and write").click()
    expect(page.locator(".refused")).to_contain_text("such as pair.wood-steel")


def asked(page, question):
    """Choose a question in its room."""
    page.get_by_role("tab", name="Questions").click()
    page.get_by_label("Question", exact=True).select_option(label=question)


def test_each_question_has_a_form_and_a_way_to_begin(studio, opened):
    page = opened(studio.address)
    page.get_by_role("tab", name="Questions").click()
    questions = page.get_by_label("Question", exact=True).locator("option").all_inner_texts()
    assert len(questions) == 7
    for question in questions:
        asked(page, question)
        begin = page.get_by_role("button", name=re.compile("^(Start|What will it take.)$"))
        expect(begin).to_be_visible(timeout=60_000)


def test_a_map_says_its_cost_is_computed_and_seen_again_by_a_page_that_was_reloaded(studio, opened):
    page = opened(studio.address)
    asked(page, "Efficiency over frequency and amplitude")
    page.get_by_label("frequencies").fill("40")
    page.get_by_label("gammas").fill("10,20")
    page.locator("summary", has_text="changes of the case").click()
    for name, value in (("count", "20"), ("cycles", "2"), ("discard", "1")):
        page.get_by_label(name, exact=True).fill(value)
    page.get_by_role("button", name="What will it take?").click()
    expect(page.locator(".answer")).to_contain_text("2 runs, 0 of them finished", timeout=60_000)
    page.get_by_role("button", name="Start").click()
    expect(page.get_by_role("button", name="Stop")).to_be_visible(timeout=60_000)
    page.reload()
    asked(page, "Efficiency over frequency and amplitude")
    expect(page.get_by_label("gammas")).to_have_value("10,20")
    expect(page.locator(".figures img").first).to_be_visible(timeout=300_000)
    expect(page.locator(".answer")).to_contain_text("2 done, 0 failed")
    page.locator("summary", has_text="Started before").click()
    page.get_by_role("button", name="--dry-run").click()
    expect(page.locator(".answer")).to_contain_text("0 of them finished")


def test_a_load_is_answered_by_its_own_page_in_a_frame(studio, opened):
    page = opened(studio.address)
    asked(page, "What load is on the wall?")
    page.get_by_label("height [m]").fill("7")
    page.get_by_role("button", name="Start").click()
    expect(page.locator(".refused")).to_contain_text("silo.toml: [silo] height")
    page.get_by_label("height [m]").fill("7 m")
    page.get_by_role("button", name="Start").click()
    expect(page.locator(".answer")).to_contain_text("walls 7 m high", timeout=60_000)
    expect(page.frame_locator("iframe").locator("h1")).to_contain_text("Loads on silo")
    assert tomllib.loads((studio.folder / "silo.toml").read_text())["silo"]["height"] == "7 m"


def test_an_answer_that_is_lost_is_asked_for_again(studio, opened):
    page, lost = opened(studio.address), []

    def lose(route):
        if lost:
            route.continue_()
        else:
            lost.append(route)
            route.fulfill(json={"refusal": "lost on its way"})

    page.route("**/api/measured*", lose)
    asked(page, "At which amplitude is a damper best?")
    page.get_by_role("button", name="Start").click()
    expect(page.locator(".refused")).to_have_text("lost on its way")
    expect(page.locator(".answer")).to_contain_text("clearance", timeout=60_000)
    expect(page.locator(".refused")).to_have_count(0)


def test_a_list_that_gets_focus_has_the_files_that_came_meanwhile(studio, opened):
    page = opened(studio.address)
    page.get_by_role("tab", name="Laboratory").click()
    files = page.get_by_label("Files in the folder")
    expect(files).to_be_visible()
    (studio.folder / "late.csv").write_text("a,b\n1,2\n")
    files.focus()
    expect(files.locator("option[value='late.csv']")).to_have_count(1)
    asked(page, "Which outlet is safe?")
    cases = page.get_by_label("Case of the question")
    expect(cases).to_have_value("A3")
    (studio.folder / "late.toml").write_text('schema = 1\n[silo]\npreset = "A4"\n')
    cases.focus()
    expect(cases.locator("option[value='late.toml']")).to_have_count(1)
    expect(cases).to_have_value("A3")
    page.get_by_role("tab", name="Laboratory").click()
    page.locator("summary", has_text="Write the value").click()
    page.get_by_label("into").focus()
    expect(page.locator("datalist option[value='late.toml']")).to_have_count(1)


NAMELESS = """
() => [...document.querySelectorAll("input, select, textarea, button")]
  .filter((one) => one.type !== "file" && !one.labels?.length && !one.ariaLabel
    && !one.textContent.trim())
  .map((one) => one.outerHTML)
"""


def test_two_runs_are_set_side_by_side(studio, opened, reference):
    for name in (reference.path.name, "copy"):
        shutil.copytree(reference.path, studio.folder / "runs" / name, dirs_exist_ok=True)
    page = opened(studio.address)
    page.get_by_role("tab", name="Runs").click()
    page.get_by_role("button", name=reference.path.name).click()
    page.locator("summary", has_text="Compare with another run").click()
    page.get_by_label("Another run").select_option("copy")
    page.get_by_role("button", name="Compare").click()
    expect(page.locator(".run")).to_contain_text("curves 0.000 s apart", timeout=60_000)


DROPPED = """
() => {
  const data = new DataTransfer();
  const table = "height [mm],rebound [mm]\\n500,281\\n500,280\\n500,283\\n";
  data.items.add(new File([table], "drops.csv", { type: "text/csv" }));
  data.items.add(new File(["<html>"], "film.mp4", { type: "video/mp4" }));
  document.querySelector(".drop").dispatchEvent(
    new DragEvent("drop", { dataTransfer: data, bubbles: true, cancelable: true }));
}
"""


def test_a_table_is_dropped_and_what_is_no_film_refused(studio, opened):
    """sqrt(281/500) = 0.7497 and its like: their mean is 0.750."""
    page = opened(studio.address)
    page.get_by_role("tab", name="Laboratory").click()
    page.get_by_label("Measurement").select_option("calibrate heights")
    expect(page.locator(".lab")).to_contain_text("heights of drop and rebound")
    expect(page.locator(".drop")).to_be_visible()
    page.evaluate(DROPPED)
    expect(page.locator(".refused")).to_contain_text("film.mp4: its content is no MP4 file")
    expect(page.locator(".lab .list").first).to_contain_text("drops.csv")
    page.get_by_role("button", name="Measure", exact=True).click()
    expect(page.locator(".answer")).to_contain_text("0.7501", timeout=60_000)
    page.get_by_label("Measurement").select_option("calibrate incline")
    expect(page.locator(".answer")).to_have_count(0)
    page.get_by_label("Measurement").select_option("calibrate heights")
    expect(page.locator(".answer")).to_contain_text("0.7501")
    expect(page.locator(".lab .list").first).to_contain_text("drops.csv")


def test_a_form_that_comes_late_does_not_replace_the_chosen_one(studio, opened):
    """The first measurement's form is held back until another has been chosen and shown."""
    page, held = opened(studio.address), []
    page.route(
        "**/*task*",
        lambda route: held.append(route) if not held else route.continue_(),
    )
    page.get_by_role("tab", name="Laboratory").click()
    page.wait_for_timeout(300)
    page.get_by_label("Measurement").select_option("calibrate heights")
    expect(page.locator(".lab")).to_contain_text("heights of drop and rebound")
    expect(page.locator(".lab .quiet").first).to_contain_text("heights")
    with page.expect_response("**/*task*"):
        held[0].continue_()
    page.wait_for_timeout(300)
    expect(page.locator(".lab .quiet").first).to_contain_text("heights")


@pytest.mark.parametrize("room", ["Silo", "Damper", "Questions", "Laboratory", "Runs"])
def test_every_room_fits_a_telephone_light_and_dark(studio, opened, room):
    """At 360 px nothing sticks out to the side; every control has a name."""
    for scheme in ("light", "dark"):
        page = opened(studio.address, width=360, height=740, scheme=scheme)
        page.get_by_role("tab", name=room).click()
        page.wait_for_timeout(800)
        assert page.evaluate("() => document.documentElement.scrollWidth") == 360
        background = page.evaluate("() => getComputedStyle(document.body).backgroundColor")
        assert background == {"dark": "rgb(25, 26, 28)", "light": "rgb(251, 250, 247)"}[scheme]
        assert page.evaluate(NAMELESS) == []


def test_what_files_say_is_text_and_never_markup(studio, opened):
    """A name and a source that hold tags are shown as they are, and run nothing."""
    (studio.folder / "mat.toml").write_text(
        'schema = 1\n[material.wood]\ndensity = { value = "0.45 g/cm3", '
        'source = "<img src=x onerror=alert(1)>" }\n'
    )
    page = opened(studio.address)
    page.get_by_label("materials", exact=True).fill("mat.toml")
    page.locator("summary", has_text="Materials and their sources").click()
    expect(page.locator("table").first).to_contain_text("<img src=x onerror=alert(1)>")
    assert page.locator("table img").count() == 0
    page.get_by_label("Name of the case").fill("<b>x</b>")
    expect(page.locator(".refused")).to_contain_text("<b>x</b>")


def test_the_scripts_set_no_markup():
    """textContent and elements alone: nothing that is read becomes HTML."""
    page = Path(__file__).parents[2] / "granulab" / "studio" / "page"
    for script in page.glob("*.js"):
        text = script.read_text()
        for way in ("innerHTML", "outerHTML", "insertAdjacentHTML", "document.write", "eval("):
            assert way not in text, (script.name, way)
