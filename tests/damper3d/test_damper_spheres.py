"""Spheres in a picture: where they are, how large, and which of two hides the other."""

import numpy as np
import pytest
from fuzzing import examples
from hypothesis import given, settings
from hypothesis import strategies as st

from damper3d.view.spheres import Window, draw_spheres

WHITE = (1.0, 1.0, 1.0)
RED, BLUE = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])
WINDOW = Window(-0.02, 0.02, -0.01, 0.01, 10_000.0)  # 400 x 200 pixels


def inked(picture: np.ndarray) -> np.ndarray:
    """Which pixels are not paper."""
    return (picture != 255).any(axis=2)


def test_a_sphere_covers_its_circle_at_its_position():
    """pi r^2 of area about its centre; its rim, of half-covered pixels, is all that may differ."""
    centre, radius = np.array([[0.006, -0.002, 0.0]]), np.array([0.004])
    seen = inked(draw_spheres(centre, radius, RED[None], WINDOW, WHITE))
    rows, columns = np.nonzero(seen)
    rim = 2 * np.pi * 40  # pixels of the outline
    assert seen.sum() == pytest.approx(np.pi * 40**2, abs=rim)
    assert columns.mean() + 0.5 == pytest.approx((0.006 + 0.02) * 1e4, abs=0.5)
    assert rows.mean() + 0.5 == pytest.approx((0.01 + 0.002) * 1e4, abs=0.5)


@settings(max_examples=examples(30), deadline=None)
@given(
    apart=st.tuples(*[st.floats(-0.003, 0.003)] * 3),
    radii=st.tuples(*[st.floats(0.001, 0.005)] * 2),
)
def test_what_is_nearer_hides_what_is_behind(apart, radii):
    """At every pixel the surface z + sqrt(r^2 - d^2) that is nearest to the eye is seen.

    Also of spheres that overlap, where the order of their centres would be wrong. Left out:
    pixels within one of a rim or of the line where both surfaces meet (their mean is drawn).
    """
    centre = np.array([[0.0, 0.0, 0.0], apart])
    picture = draw_spheres(centre, np.array(radii), np.stack([RED, BLUE]), WINDOW, WHITE)
    x, y = np.meshgrid((np.arange(400) + 0.5) / 1e4 - 0.02, 0.01 - (np.arange(200) + 0.5) / 1e4)
    surface = []
    for (cx, cy, cz), r in zip(centre, radii, strict=True):
        over = r**2 - (x - cx) ** 2 - (y - cy) ** 2
        surface.append(np.where(over > 0, cz + np.sqrt(np.maximum(over, 0)), -np.inf))
    nearest = np.where(np.isinf(surface).all(axis=0), -1, np.argmax(surface, axis=0))
    sure = np.ones_like(nearest, dtype=bool)
    for shift in [(a, b) for a in (-1, 0, 1) for b in (-1, 0, 1)]:
        sure &= np.roll(nearest, shift, axis=(0, 1)) == nearest
    channels = picture.astype(int)
    redder = channels[..., 0] > channels[..., 2]  # a highlight adds as much to both
    bluer = channels[..., 2] > channels[..., 0]
    assert redder[sure & (nearest == 0)].all()
    assert bluer[sure & (nearest == 1)].all()
    assert not inked(picture)[sure & (nearest == -1)].any()


def test_light_falls_from_the_upper_left_and_far_spheres_are_darker():
    """The colour, not its brightness, carries the value: channels keep their order."""
    centre = np.array([[-0.01, 0.0, 0.0], [0.01, 0.0, -0.02]])
    colour = np.array([[0.8, 0.4, 0.2]] * 2)
    picture = draw_spheres(centre, np.full(2, 0.005), colour, WINDOW, WHITE).astype(float)
    near, far = picture[:, :200], picture[:, 200:]
    assert near[70, 70].sum() > near[130, 130].sum()
    assert far[100, 100].sum() < 0.7 * near[100, 100].sum()
    one, other = near[110, 110], far[110, 110]
    # The same factor for red, green and blue, but for half a step of rounding of either.
    np.testing.assert_allclose(other, one * other[0] / one[0], atol=1.0)


def test_spheres_that_reach_over_the_edge_are_cut_off():
    """And those outside are not drawn at all."""
    centre = np.array([[0.02, 0.01, 0.0], [0.05, 0.0, 0.0]])
    seen = inked(draw_spheres(centre, np.full(2, 0.004), np.stack([RED, RED]), WINDOW, WHITE))
    quarter = np.pi * 40**2 / 4
    assert seen.sum() == pytest.approx(quarter, abs=np.pi * 40)
    assert not seen[41:].any()
    assert not seen[:, :-41].any()


def test_a_picture_of_nothing_is_paper():
    """A bed that lies wholly in the half that is taken away."""
    empty = draw_spheres(np.empty((0, 3)), np.empty(0), np.empty((0, 3)), WINDOW, WHITE)
    assert empty.shape == (200, 400, 3)
    assert (empty == 255).all()
