"""Pages: what is packed comes back, what is in them cannot act, and they ask for nothing."""

import base64
import hashlib
import json
import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from read_page import element, read_page, unpacked

from granulab.campaign.output.page.document import document
from granulab.campaign.output.page.packing import (
    LEVELS,
    Quantised,
    counted,
    linear,
    logarithmic,
    packed,
)
from granulab.campaign.output.page.player import SCRIPTS, Recording, Touching, player
from granulab.campaign.output.page.study import SCRIPTS as STUDY_SCRIPTS
from granulab.errors import InputError

SHAPES = st.tuples(st.integers(1, 6), st.integers(1, 4))
HOSTILE = "</script><script>window.harmed = true</script><!--data--> <b>&amp;"


@given(
    arrays(np.uint16, SHAPES, elements=st.integers(0, 65535)),
    st.integers(0, 2),
)
def test_integers_come_back_whatever_they_and_the_order_of_differences_are(integers, order):
    """Modulo 2^16 nothing is lost: differences of any order are summed to the same integers."""
    heads, binary = packed({"a": Quantised(integers, order=order), "b": counted([3, 1, 2])})
    found = unpacked(heads, binary)
    np.testing.assert_array_equal(found["a"], integers)
    np.testing.assert_array_equal(found["b"], [3, 1, 2])


@given(arrays(float, 7, elements=st.floats(-1e3, 1e3)), st.floats(1e-6, 1.0))
def test_values_come_back_to_half_a_step(values, step):
    """Rounded to steps; where 2^16 of them do not reach, to 2^16 parts of the span."""
    coarsest = max(step, np.ptp(values) / 65535)
    error = np.abs(linear(values, step).values - values)
    assert error.max() <= 0.5 * coarsest * (1 + 1e-9) + 1e-9


def test_values_over_decades_come_back_to_half_a_part_and_nothing_stays_nothing():
    """A step is 1/999 of three decades, 0.69 %; what is smaller counts as the smallest."""
    values = np.array([0.0, 1e-9, 2e-3, 0.5, 1.0])
    found = logarithmic(values, 3.0).values
    half = np.exp(0.5 * 3.0 * np.log(10) / (LEVELS - 1)) - 1
    np.testing.assert_allclose(found[2:], values[2:], rtol=1.01 * half)
    assert found[0] == 0.0
    assert found[1] == pytest.approx(1e-3)


def test_smooth_motion_packs_into_few_bytes():
    """Second differences of a free fall in steps of 10 um at 10 ms are constant to rounding."""
    time = 0.01 * np.arange(500)[:, None]
    falls = 0.5 * 9.81 * time**2 % 0.5 + np.linspace(0, 0.1, 40)
    _, smooth = packed({"a": linear(0.5 * 9.81 * time**2 * 1e-3 + np.zeros(40), 1e-5, order=2)})
    _, plain = packed({"a": linear(falls, 1e-5, order=0)})
    assert len(smooth) < 0.2 * len(plain)


@pytest.mark.parametrize(
    ("template", "scripts"), [("player.html", SCRIPTS), ("study.html", STUDY_SCRIPTS)]
)
def test_what_data_say_stays_data(template, scripts):
    """No element begins or ends in it, and it comes back letter for letter."""
    data = {"title": HOSTILE, "cells": [HOSTILE, 1.5, None]}
    page = document(template, scripts, HOSTILE, data)
    assert json.loads(element(page, "data")) == data
    assert page.count("<script") == page.count("</script>") == page.count("<script type=")
    assert "<title>&lt;/script&gt;&lt;script&gt;window" in page
    with pytest.raises(ValueError, match="not JSON compliant"):
        document(template, scripts, "", {"a": float("nan")})


@pytest.mark.parametrize(
    ("template", "scripts"), [("player.html", SCRIPTS), ("study.html", STUDY_SCRIPTS)]
)
def test_only_the_page_s_own_script_and_style_run_and_nothing_is_fetched(template, scripts):
    """The policy knows both by their SHA-256, and default-src is none; the page has no address."""
    page = document(template, scripts, "a page", {})
    policy = re.findall(r'<meta http-equiv="Content-Security-Policy" content="([^"]*)">', page)[0]
    rules = dict(rule.strip().split(" ", 1) for rule in policy.split(";"))
    texts = {
        "script-src": re.findall(r'<script type="module">(.*?)</script>', page, re.DOTALL),
        "style-src": re.findall(r"<style>(.*?)</style>", page, re.DOTALL),
    }
    for name, (text,) in texts.items():
        digest = base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()
        assert rules[name] == f"'sha256-{digest}'"
    assert rules["default-src"] == "'none'"
    without_comments = re.sub(r"(?m)(^|[ ;(])//.*$", "", page)
    assert "//" not in without_comments
    assert not re.search(r"\b(import|export)\b.* from ", page)


def _recording(frames: np.ndarray, n: int = 40) -> Recording:
    rng = np.random.default_rng(1)
    noise = rng.uniform(size=(400, n))[frames]
    data = {"title": "noise", "notes": []}
    return Recording(data, {"x": linear(noise, 1e-4, order=0)})


def test_frames_are_left_out_evenly_until_the_page_is_small_enough_and_it_says_so():
    """400 frames of 40 incompressible 14-bit numbers are some 38 kB; every third of them 13 kB."""
    time = 0.1 * np.arange(400)
    whole, remark = player(_recording, time, 1e6)
    assert remark == ""
    bare = len(player(_recording, time, 1e6)[0]) - len(element(whole, "arrays"))
    most = bare + 0.4 * len(element(whole, "arrays"))
    page, remark = player(_recording, time, most)
    assert len(page) <= most
    assert re.fullmatch(r"Every 3rd of the run's 400 frames, for a page of at most \d+ kB.", remark)
    found = read_page(page)
    np.testing.assert_allclose(np.diff(found.arrays["time"]), 0.3, atol=1e-3)
    assert found.data["notes"] == [remark]
    with pytest.raises(InputError, match="--size: 2 kB hold no two frames"):
        player(_recording, time, 2e3)


def test_contacts_between_two_frames_are_those_of_the_last_moment():
    """Of the moments 0, 2, 3, 6 of a run whose frames 0, 3, 6 are shown, 0, 3 and 6 are taken."""
    at = {k: Touching(k, np.array([[0, 1], [1, 3]]), np.array([k + 1.0, 2.0]), np.zeros(2, bool),
                      np.array([[0.0, -1e-3]])) for k in (0, 2, 3, 6)}  # fmt: skip
    recording = Recording({})
    time, frames = 0.01 * np.arange(7), np.array([0, 3, 6])
    taken = recording.add_contacts(list(at.values()), time, frames, 3, ["#000000", "#ffffff"])
    assert taken == [0, 2, 3]
    found = {name: array.values for name, array in recording.arrays.items()}
    np.testing.assert_allclose(found["moment_time"], [0, 0.03, 0.06], atol=1e-6)
    np.testing.assert_array_equal(found["moment_frame"], [0, 1, 2])
    np.testing.assert_allclose(found["force"][::2], [1, 4, 7], rtol=6e-3)  # half of 1.16 %
    # On particle 1 act all forces, the largest sum of which ends the scale.
    assert recording.colours[-1].high == pytest.approx(9.0, rel=0.05)


def test_more_particles_than_sixteen_bits_count_are_refused():
    with pytest.raises(InputError, match="70,000 particles and walls: a page counts to 65,535"):
        counted([70_000])
