"""The paper's remarks: pauses of streams that are known, and claims over made-up rows."""

import math
from pathlib import Path

import h5py
import numpy as np
import pytest
from made_rows import clogged, emptied, line_of

from granulab.campaign.claims.claim import claims_of
from granulab.campaign.output.figure import write_figure
from silo2d.case.case import GRAVITY
from silo2d.case.outline import preset
from silo2d.reproduce.quantities.remarks import REMARKS, pauses
from silo2d.reproduce.remarks import _OFTEN, _SOFT, cases, draw, measured, report

SIZE = 9e-3  # [m]
FALL = math.sqrt(2 * SIZE / GRAVITY)  # [s]


def stream(*waits: float) -> np.ndarray:
    return np.cumsum(waits)


def test_a_stream_whose_particles_follow_each_other_has_no_pause():
    assert pauses(stream(*[0.99 * FALL] * 50), SIZE) == []
    assert pauses([], SIZE) == []
    assert pauses([0.1], SIZE) == []


def test_pauses_are_waits_in_which_one_falls_farther_than_its_size():
    """Of 50 that leave the waits count from the 5th to the 45th: those of the last 5 do not."""
    waits = [0.1 * FALL] * 50
    waits[2] = waits[47] = 3 * FALL
    assert pauses(stream(*waits), SIZE) == []
    waits[20], waits[30], waits[31] = 1.01 * FALL, 2 * FALL, 0.99 * FALL
    assert pauses(stream(*waits), SIZE) == pytest.approx([1.01 * FALL, 2 * FALL])


def made(particles=14, pauses_at=None, overlap=0.15) -> list[dict]:
    """Rows that keep every remark, but for what is given otherwise."""
    none = {"arch_particles": None, "pauses": 0, "longest_pause_s": None, "largest_overlap_m": None}
    many, rows = {"A3": 2, "B3": 1, "C3": 1, "D3": 4} | (pauses_at or {}), []
    for silo in (f"{letter}{outlet}" for letter in "ABCD" for outlet in range(1, 5)):
        small = silo[1] in "12"
        for row in clogged(silo, 2) if small else emptied(silo, [2.0, 2.1]):
            n = many.get(silo, 0)
            found = none | {"kn": None, "outlet_mm": round(1e3 * preset(silo).outlet)}
            found |= {"pauses": n, "longest_pause_s": 0.06 if n else None}
            rows.append(row | found | ({"arch_particles": particles} if small else {}))
    for kn, deep in ((1e3, overlap), (1e4, 0.01)):
        rows += [row | none | {"kn": kn, "pauses": None, "largest_overlap_m": 1e-3 * deep}
                 for row in emptied("A4", [1.0])]  # fmt: skip
    return rows


def verdicts(rows: list[dict]) -> dict[str, list[bool | None]]:
    claims = claims_of("silo_remarks")
    found = REMARKS.judge(claims, rows)
    return {
        claim.id: [check.holds for check in verdict.checks]
        for claim, verdict in zip(claims, found, strict=True)
    }


def test_rows_that_keep_the_remarks_hold_in_every_claim():
    assert all(all(checks) for checks in verdicts(made()).values()), verdicts(made())


@pytest.mark.parametrize(
    ("claim", "changes"),
    [
        ("arches-up-to-16", {"particles": 17}),
        ("interrupted-at-100-mm", {"pauses_at": {"B3": 0}}),
        ("flows-freely-at-150-mm", {"pauses_at": {"C4": 1}}),
        ("overlap-unrealistic-at-1e3", {"overlap": 0.028}),
    ],
)
def test_a_remark_that_is_broken_is_seen_and_the_others_stay(claim, changes):
    found = verdicts(made(**changes))
    assert False in found[claim]
    assert not any(False in checks for name, checks in found.items() if name != claim)


def test_the_table_is_told_and_drawn(tmp_path):
    text = report(made())
    assert line_of(text, "D3").split("0 of 2")[1].split() == [
        "-",
        "8",
        "in",
        "2",
        "runs",
        "0.060",
        "s",
    ]
    assert "14, 14" in line_of(text, "A1")
    assert "largest overlap: 0.150 mm at 1000 N/mm, 0.010 mm at 10000 N/mm" in text
    assert write_figure(tmp_path / "remarks.png", lambda: draw(made())).exists()


def test_numbers_of_a_run_are_those_in_its_folder(reference):
    """One that emptied has no arch; the deepest of its contacts is the largest overlap."""
    run = {"silo": "A4", "state": "done", "outcome": "empty", "run_folder": str(reference.path)}
    usual = measured(run | {"kn": None})
    assert usual["outlet_mm"] == 150
    assert usual["arch_particles"] is None
    assert usual["pauses"] >= 0
    assert usual["largest_overlap_m"] is None
    soft = measured(run | {"kn": _SOFT})
    with h5py.File(Path(reference.path) / "trajectory.h5") as file:
        assert soft["largest_overlap_m"] == file["tables/contacts/columns/overlap"][:].max() > 0


def test_softer_contacts_keep_their_ratios():
    """A4 has kn = 1e4 N/mm: a tenth of it with a tenth of kt, and damping by its root."""
    of = {labels["kn"]: case for labels, case in cases([1])}
    usual, soft = of[1e4].particle_law, of[_SOFT].particle_law
    assert soft.kn / usual.kn == pytest.approx(0.1)
    assert soft.kt / usual.kt == pytest.approx(0.1)
    assert soft.gamma_n / usual.gamma_n == pytest.approx(math.sqrt(0.1))
    assert _OFTEN["law.keep_ratios"]
