"""The ranking of a sweep in a browser: words in its cells, and numbers by which they sort."""

from pathlib import Path

import pytest
from made_sweeps import MADE, B, compared, run, seeds

from granulab.campaign.output.page.study import study_page
from granulab.campaign.output.table import write_table
from granulab.campaign.sweeps.report.summary import summary, write_ranking


@pytest.fixture
def shown(tmp_path: Path, open_page):
    """A study of three combinations: by letters "12.0 ..." would come before "3.2 ..."."""
    rows = [*seeds([11.0, 13.0], **{"b.count": 1}), *seeds([3.0, 3.4], **{"b.count": 2}),
            run(None, 1, stuck=True, **{"b.count": 3})]  # fmt: skip
    for row in rows:
        row["run_folder"] = str(tmp_path / "gone")
    comparison = compared([B], rows)
    write_table(tmp_path, rows)
    write_ranking(tmp_path, comparison, summary(comparison, tmp_path))
    names = [number.column for number in MADE.numbers]
    (tmp_path / "page.html").write_text(study_page(tmp_path, names, tmp_path / "page.html"))
    return open_page(tmp_path / "page.html", ready="study")


def test_a_column_of_estimates_sorts_by_their_means(shown):
    table = shown.page.locator("#tables section").first
    assert "Combinations, the best first" in table.inner_text()
    assert "ranked by share stuck" in table.inner_text()
    heads = table.locator("th").all_inner_texts()
    cells = table.locator(f"tr td:nth-child({heads.index('speed') + 2})")
    assert cells.all_inner_texts() == ["12 ± 13 (2)", "3.2 ± 2.5 (2)", "–"]
    table.get_by_role("button", name="speed", exact=True).click()
    assert cells.all_inner_texts() == ["3.2 ± 2.5 (2)", "12 ± 13 (2)", "–"]
    assert shown.errors == []
