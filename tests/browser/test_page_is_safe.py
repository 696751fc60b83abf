"""Pages that hold what others wrote, and browsers that lack something: nothing breaks."""

import dataclasses
import shutil

import pytest
from fake_run import write_fake_run

from silo2d.view import player

HOSTILE = '</script><script>window.harmed = true</script><img src=x onerror="harmed = true">'
NO_WEBGL = """
const real = HTMLCanvasElement.prototype.getContext;
HTMLCanvasElement.prototype.getContext = function (kind, ...more) {
  return kind === "webgl2" ? null : real.call(this, kind, ...more);
};
"""


def test_a_name_with_tags_is_shown_as_text_and_does_nothing(tmp_path, open_page, monkeypatch):
    """Of the silo, and of a wall: both are the user's."""
    run = write_fake_run(tmp_path / "run")
    real = player.read_scene

    def named(folder):
        scene = real(folder)
        scene.trajectory.attributes["silo"] = HOSTILE
        return dataclasses.replace(scene, wall_names=[HOSTILE, *scene.wall_names[1:]])

    monkeypatch.setattr(player, "read_scene", named)
    path = tmp_path / "page.html"
    path.write_text(player.player_page(run.path, 2.5e6)[0], encoding="utf-8")
    shown = open_page(path)
    shown.page.locator("#forces-of-walls summary").click()
    shown.shown("player.redraw()")
    assert shown.run("window.harmed") is None
    assert HOSTILE in shown.page.locator("#title").inner_text()
    assert HOSTILE in shown.page.locator("#wall-table").inner_text()
    assert shown.run("document.querySelectorAll('#title img, #wall-table img').length") == 0


def test_the_policy_of_the_page_stops_what_would_be_added(silo_page, open_page, tmp_path):
    """A script that someone pastes into the file does not run, and nothing is fetched by it."""
    path = tmp_path / "page.html"
    text = silo_page.read_text("utf-8")
    added = '<script>window.harmed = true</script><img src="https://example.org/seen.png"></body>'
    path.write_text(text.replace("</body>", added), "utf-8")
    shown = open_page(path)
    assert shown.run("window.harmed") is None
    assert shown.run("player.frames") > 1
    assert len(shown.errors) == 2
    assert all("Content Security Policy" in error for error in shown.errors)
    shown.errors.clear()
    shown.requests[:] = [url for url in shown.requests if "example.org" not in url]


def test_without_webgl_the_page_says_so_and_shows_its_curves(damper_page, open_page):
    shown = open_page(damper_page, before=NO_WEBGL)
    assert "no WebGL2" in shown.page.locator("#message").inner_text()
    shown.page.keyboard.press("ArrowRight")
    shown.page.keyboard.press("s")
    assert shown.run("player.state.frame") == 1
    drawn = shown.run(
        "(() => { const c = player.curves; const d = c.context.getImageData(0, 0, c.canvas.width,"
        " c.canvas.height).data; let n = 0; for (let k = 3; k < d.length; k += 4) n += d[k] > 0;"
        " return n; })()"
    )
    assert drawn > 1000


def test_a_browser_that_cannot_inflate_is_told_so(silo_page, open_page):
    shown = open_page(silo_page, before="delete window.DecompressionStream;")
    assert "of 2023 or later" in shown.page.locator("#message").inner_text()
    assert len(shown.errors) == 1
    shown.errors.clear()


@pytest.mark.parametrize("word", ["a name with spaces", "größer Опыт", "50% #1?"])
def test_pages_open_from_folders_of_any_name(silo_page, open_page, tmp_path, word):
    folder = tmp_path / word
    folder.mkdir()
    shutil.copy(silo_page, folder / "page.html")
    shown = open_page(folder / "page.html")
    assert shown.run("player.frames") > 1
