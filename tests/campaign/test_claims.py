"""Claims as data: each rule on made items that hold and that fail, the words, the shipped files."""

import importlib

import pandas as pd
import pytest

from granulab.campaign.claims.claim import Claim, Criterion, claims_of
from granulab.campaign.claims.judge import Check, Quantities, Verdict, report_claims
from granulab.campaign.claims.rules import RULES, all_of
from granulab.contact.files.datafile import data_root

NAN = float("nan")

# Where the quantities of each file of claims are registered.
REGISTRIES = {
    "damper_cycles": ("damper3d.reproduce.quantities.cycles", "CYCLES"),
    "damper_design_rules": ("damper3d.reproduce.quantities.rules", "RULES"),
    "damper_experiments": ("damper3d.reproduce.quantities.experiments", "EXPERIMENTS"),
    "damper_measured": ("damper3d.reproduce.measured.quantities", "MEASURED"),
    "damper_map": ("damper3d.reproduce.quantities.maps", "MAPS"),
    "damper_optimum": ("damper3d.reproduce.quantities.optima", "OPTIMA"),
    "damper_overestimate": ("damper3d.reproduce.quantities.maps", "MAPS"),
    "damper_packing": ("damper3d.reproduce.quantities.packing", "PACKINGS"),
    "damper_phases": ("damper3d.reproduce.phases.quantities", "PHASE_MAPS"),
    "damper_printed": ("damper3d.reproduce.printed.quantities", "PRINTED"),
    "damper_sensitivity": ("damper3d.reproduce.quantities.sensitivity", "SENSITIVITY"),
    "damper_shapes": ("damper3d.reproduce.quantities.shapes", "SHAPES"),
    "damper_shares": ("damper3d.reproduce.quantities.shares", "SHARES"),
    "damper_sizes": ("damper3d.reproduce.sizes", "QUANTITIES"),
    "damper_compress": ("damper3d.studies.quasistatic.claims", "SLOW"),
    "damper_shear": ("damper3d.studies.quasistatic.claims", "SLOW"),
    "silo_displacement": ("silo2d.reproduce.quantities.displacement", "PROFILES"),
    "silo_remarks": ("silo2d.reproduce.quantities.remarks", "REMARKS"),
}


def items(*values, **columns):
    """Items at x = 1, 2, ... with these values."""
    return pd.DataFrame({"x": range(1, len(values) + 1), "value": values, **columns})


def holds(rule, made, **limits):
    return RULES[rule](made, **limits).holds


@pytest.mark.parametrize(("rule", "limits", "right", "wrong"), [
    ("each", {"above": 0.3}, items(0.4, 0.31), items(0.4, 0.3)),
    ("each", {"above": 0.3}, items(0.4), items(0.4, NAN)),  # what lacks is not above
    ("each", {"above": 0.3, "beyond_noise": True},
     items(0.4, noise=[0.05]), items(0.4, NAN, noise=[0.05, 0.05])),
    ("each", {"below": 1}, items(0.9), items(1.0)),
    ("each", {"at_least": -0.2, "at_most": 0.2}, items(-0.2, 0.2), items(-0.21, 0.2)),
    ("each", {"equal": 2}, items(2.0, 2.0), items(2.0, 1.5)),
    ("each", {"above": "limit"}, items(2.0, 3.0, limit=[1, 2]), items(2.0, 3.0, limit=[1, 3])),
    ("steps", {"along": "x", "way": "rises"}, items(1.0, 2.0, 3.0), items(1.0, 3.0, 2.0)),
    ("steps", {"along": "x", "way": "rises"}, items(0.0, 2.0), items(0.0, 0.0)),
    ("steps", {"along": "x", "way": "falls"}, items(3.0, 2.0), items(3.0, 3.0)),
    ("steps", {"along": "x", "way": "rises", "per": ["g"]},
     items(1.0, 2.0, 1.5, 2.5, g=[1, 1, 2, 2]), items(1.0, 2.0, 2.5, 1.5, g=[1, 1, 2, 2])),
    ("ordered", {"first": {"x": 2}, "way": "above", "second": {"x": 1}},
     items(1.0, 1.1), items(1.1, 1.0)),
    ("ordered", {"first": {"x": 2}, "way": "above", "second": {"x": 1}, "factor": 1.5},
     items(1.0, 1.6), items(1.0, 1.4)),
    ("ordered", {"first": {"x": 3}, "way": "below", "second": {"x": [1, 2]}},
     items(1.0, 2.0, 1.4), items(1.0, 2.0, 1.6)),  # the mean of two
    ("ordered", {"first": {"x": 1}, "way": "below", "second": {"x": 2}, "per": ["g"]},
     pd.DataFrame({"x": [1, 2, 1, 2], "g": [1, 1, 2, 2], "value": [1.0, 2, 3, 4]}),
     pd.DataFrame({"x": [1, 2, 1, 2], "g": [1, 1, 2, 2], "value": [1.0, 2, 4, 3]})),
    ("extreme", {"least": {"x": 2}, "need": 3}, items(2.0, 1.0, 3.0), items(1.0, 2.0, 3.0)),
    ("extreme", {"largest": {"x": 3}}, items(2.0, 1.0, 3.0), items(5.0, 2.0, 3.0)),
    ("ratio", {"at_most": 1.5}, items(1.0, 1.5), items(1.0, 1.6)),
    ("ratio", {"at_most": 1.5}, items(1.0, 1.2), items(-1.0, 3.0)),
    ("ratio", {"at_most": 1.5}, items(1.0, 1.2), items(0.0, 3.0)),
    ("ratio", {"at_most": 1.5, "per": ["g"]},
     items(1.0, 1.4, 10.0, 11.0, g=[1, 1, 2, 2]), items(1.0, 1.4, 10.0, 16.0, g=[1, 1, 2, 2])),
    ("compared", {"printed": 0.64, "within": 0.01}, items(0.635), items(0.62)),
    ("compared", {"printed": 2, "within": "noise"},
     items(1.9, noise=[0.2]), items(1.9, noise=[0.05])),
    ("compared", {"printed": 2, "within": "noise", "telling": 0.1},
     items(1.95, noise=[0.1]), items(1.7, noise=[0.2])),
    ("compared", {"printed": 3, "factor": 1.5}, items(2.1, 4.4), items(1.9)),
    ("compared", {"printed": 0.8, "within": 0.1, "mean": True}, items(0.6, 0.9), items(0.6, 0.7)),
    ("compared", {"printed": "x", "interval": ["a", "b", "c", "d"]},
     items(1.0, a=[0.9], b=[1.1], c=[1.1], d=[1.2]), items(1.0, a=[0.9], b=[1.1], c=[1.15], d=[2])),
])  # fmt: skip
def test_rule_holds_of_made_items_and_fails_of_others(rule, limits, right, wrong):
    assert holds(rule, right, **limits) is True
    assert holds(rule, wrong, **limits) is False


@pytest.mark.parametrize(("rule", "limits", "made"), [
    ("each", {"above": 0, "beyond_noise": True}, items(0.1, noise=[0.2])),
    ("each", {"above": 0, "beyond_noise": True}, items(0.1, noise=[NAN])),
    ("each", {"above": 0, "need": 3}, items(1.0, 2.0)),
    ("steps", {"along": "x", "way": "rises"}, items(1.0, NAN)),
    ("ordered", {"first": {"x": 2}, "way": "above", "second": {"x": [1, 3]}}, items(1.0, 2.0)),
    ("ordered", {"first": {"x": [1, 2]}, "way": "above", "second": {"x": [3, 4]}},
     pd.DataFrame({"x": [1, 1, 3, 3], "value": [2.0, 2.0, 1.0, 1.0]})),  # two of one are not two
    ("extreme", {"least": {"x": 9}}, items(1.0, 2.0)),
    ("ratio", {"at_most": 1.5, "need": 3}, items(1.0, 1.2)),
    ("ratio", {"at_most": 1.5}, items(0.0, 0.0)),
    ("compared", {"printed": 1.0, "within": 0.1}, items(NAN)),
    ("compared", {"printed": 2, "within": "noise"}, items(1.9, noise=[NAN])),
    ("compared", {"printed": 2, "within": "noise", "telling": 0.1}, items(1.95, noise=[0.2])),
])  # fmt: skip
def test_too_few_or_too_noisy_items_are_not_judged(rule, limits, made):
    assert holds(rule, made, **limits) is None


def test_a_claim_holds_where_all_its_checks_do():
    assert all_of([True, True]) is True
    assert all_of([True, None]) is None
    assert all_of([None, False]) is False
    assert all_of([]) is None


def _claim(*criteria, sentence="It rises."):
    return Claim("it", "a thesis", sentence, criteria, "source")


@pytest.fixture
def made():
    found = Quantities()

    @found.quantity
    def level(readings, times=1.0):
        return [{"size": s, "x": x, "value": times * v} for s, x, v in readings]

    @found.function
    def odd(readings):
        return [Check(len(readings) % 2 == 1, f"{len(readings)} of them")]

    return found


READINGS = [(3, 1.0, 0.2), (3, 2.0, 0.4), (5, 1.0, 0.3), (5, 2.0, 0.1)]


def test_a_criterion_selects_groups_judges_and_reports_what_decided(made):
    words = {"of": "{size} mm", "item": "{value:.0f %} at {x:g}", "but": "; not {failed}",
             "case": "{low:g} to {high:g}"}  # fmt: skip
    rule = {"name": "steps", "along": "x", "way": "rises"}
    one = Criterion("level", {"times": 2.0}, {}, {"size": [3, 4, 5]}, rule, words=words)
    (verdict,) = made.judge([_claim(one)], READINGS)
    assert verdict.checks == [
        Check(True, "40 % at 1, 80 % at 2", "3 mm"),
        Check(None, "", "4 mm"),
        Check(False, "60 % at 1, 20 % at 2; not 1 to 2", "5 mm"),
    ]
    only = Criterion("level", {}, {"size": 3}, (), {"name": "each", "above": 0.3},
                     words={"item": "{x:g}", "found": "{passed} of {n}, mean {mean:percent}",
                            "but": "; not at {failed}"})  # fmt: skip
    assert made.judge([_claim(only)], READINGS)[0].checks == [
        Check(False, "1 of 2, mean 30 %; not at 1")
    ]


def test_a_claim_that_fits_no_rule_has_a_function(made):
    (verdict,) = made.judge([_claim(Criterion(function="odd"))], READINGS)
    assert verdict.checks == [Check(False, "4 of them")]


def test_claims_are_printed_with_what_decided_them():
    """One check: its verdict is in front. Several, or one with a name: a line each."""
    made = {
        "The optimum rises.": [Check(True, "3 of 3 steps")],
        "It goes as f^2.": [Check(None, "")],
        "Friction is most.": [Check(True, "least 60 %", "budget"),
                              Check(False, "least 40 %", "count of all")],
        "It hardly moves.": [Check(True, "5.2 to 5.3", "modulus")],
        "It is fast.": [Check(True, "0.9 V"), Check(True, "1.0 V")],
    }  # fmt: skip
    text = report_claims([Verdict(_claim(sentence=words), own) for words, own in made.items()])
    assert text.splitlines() == [
        "claims: 3 of 4 hold, 1 cannot be judged yet (----)",
        "PASS  The optimum rises.",
        "      3 of 3 steps",
        "----  It goes as f^2.",
        "      no run",
        "Friction is most.",
        "  PASS  budget        least 60 %",
        "  FAIL  count of all  least 40 %",
        "It hardly moves.",
        "  PASS  modulus  5.2 to 5.3",
        "It is fast.",
        "  PASS  0.9 V",
        "  PASS  1.0 V",
    ]


def test_every_file_of_claims_is_listed():
    files = (data_root() / "published" / "claims").glob("*.toml")
    assert sorted(path.stem for path in files) == sorted(REGISTRIES)


@pytest.mark.parametrize("table", REGISTRIES)
def test_shipped_claims_are_whole(table):
    """Rules, quantities and functions exist; what we set has its reason; ids are distinct."""
    module, name = REGISTRIES[table]
    known = getattr(importlib.import_module(module), name)
    claims = claims_of(table)
    assert len({claim.id for claim in claims}) == len(claims)
    for claim in claims:
        assert claim.set_by in ("source", "us")
        assert claim.reason or claim.set_by == "source", claim.id
        for one in claim.criteria:
            if one.function:
                assert one.function in known.functions
            else:
                assert one.quantity in known.quantities
                assert one.rule["name"] in RULES


def test_few_claims_fit_no_rule():
    """docs/reference/claims.md lists them."""
    functions = {
        one.function for table in REGISTRIES for claim in claims_of(table) for one in claim.criteria
    } - {""}
    assert len(functions) <= 10
