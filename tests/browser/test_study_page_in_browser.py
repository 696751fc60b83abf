"""The page of a sweep or map in a browser: tables sort, points and rows lead to the runs."""

import shutil
from pathlib import Path

import pytest
from small_silo import silo2d

from granulab.campaign.output.table import write_table
from silo2d.view.player import player_page

ROWS = [(0.2, 1, 1.51), (0.2, 2, 1.53), (0.4, 1, None), (0.4, 2, 1.87)]  # mu, seed, time [s]


@pytest.fixture
def study(finished, tmp_path) -> Path:
    """A study of four rows, of which the first has a run with a page."""
    run = next(finished.glob("small-*"))
    place = tmp_path / "runs #1" / "small-seed1"
    shutil.copytree(run, place)
    page = place / "figures" / "page.html"
    page.parent.mkdir()
    page.write_text(player_page(place, 2.5e6)[0], encoding="utf-8")
    folder = tmp_path / "runs #1" / "studies" / "friction-0123"
    folder.mkdir(parents=True)
    rows = [
        {"case": "A4", "law.mu_wall": mu, "seed": seed, "outcome": "empty" if time else "clogged",
         "discharge_time_s": time, "note": "<i>x</i>", "state": "done", "reason": "",
         "run_folder": str(place if k == 0 else place.with_name("gone"))}
        for k, (mu, seed, time) in enumerate(ROWS)
    ]  # fmt: skip
    write_table(folder, rows)
    return folder


@pytest.fixture
def shown(study, open_page):
    done = silo2d("view", study)
    assert (done.code, done.err) == (0, ""), done.err
    return open_page(study / "page.html", ready="study")


def column(shown, name: str) -> list[str]:
    heads = shown.page.locator("#tables th").all_inner_texts()
    k = heads.index(name) + 2  # the first cell of a row holds its buttons
    return shown.page.locator(f"#tables tr td:nth-child({k})").all_inner_texts()


def test_a_column_sorts_up_and_down_and_gaps_come_last_or_first(shown):
    button = shown.page.get_by_role("button", name="discharge_time_s")
    button.click()
    assert column(shown, "discharge_time_s") == ["1.51", "1.53", "1.87", "–"]
    assert shown.page.locator("th[aria-sort]").get_attribute("aria-sort") == "ascending"
    button.click()
    assert column(shown, "discharge_time_s") == ["–", "1.87", "1.53", "1.51"]


def test_a_row_leads_to_its_run_and_tells_all_its_numbers(shown):
    assert shown.page.locator("#tables a").all_inner_texts() == ["play", "files"]
    shown.page.get_by_role("button", name="All numbers of this row").first.click()
    details = shown.page.locator("#tables dl").inner_text()
    assert "<i>x</i>" in details, "a column that is not shown at first, as text"
    shown.page.locator("#tables a").first.click()
    shown.page.wait_for_timeout(800)
    assert shown.page.url.endswith("figures/page.html")
    assert shown.run("player.frames") > 1


def test_a_point_leads_to_its_run_too(shown):
    x, y = shown.run("study.points.rows.find(({ k }) => k === 0).at")
    box = shown.page.locator("#points").bounding_box()
    shown.page.mouse.move(box["x"] + x, box["y"] + y)
    assert "law.mu_wall 0.2" in shown.page.locator("#pointed").inner_text()
    shown.page.mouse.click(box["x"] + x, box["y"] + y)
    shown.page.wait_for_timeout(800)
    assert shown.page.url.endswith("figures/page.html")


def test_the_plot_begins_with_what_was_varied(shown):
    chosen = {axis: shown.run(f"study.points.{axis}.selectedOptions[0].text")
              for axis in ("x", "y", "group")}  # fmt: skip
    assert chosen == {"x": "law.mu_wall", "y": "discharge_time_s", "group": "none"}
    assert shown.run("study.points.rows.length") == 3, "a run without a time has no point"


def test_it_fits_a_phone(study, shown, open_page):
    narrow = open_page(study / "page.html", ready="study", size=(360, 740))
    assert narrow.run("document.documentElement.scrollWidth") <= 360
