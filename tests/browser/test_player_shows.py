"""Pictures of the player: particles in their place, colours, forces, cut, light, dark, a phone."""

import os
from pathlib import Path

import numpy as np
import pytest
from PIL import Image, ImageDraw
from scipy.ndimage import binary_dilation, binary_erosion
from shapely import Polygon, hausdorff_distance
from test_player_plays import pixels, stage_of

from damper3d.view.scene import read_scene as damper_scene
from silo2d.view.scene import read_scene


def painted(image: np.ndarray, paper=(255, 255, 255), apart: float = 40.0) -> np.ndarray:
    """Mask of the pixels that differ from the paper."""
    return np.abs(image - np.array(paper)).max(axis=2) > apart


def test_particles_cover_the_area_that_they_have(small_silo_page, reference, open_page):
    """Area of the polygons inside [m2] times the scale squared, with half of each edge's line.

    A line of 0.8 px adds half its width all round: the perimeters times 0.4 px. Walls and words are
    left out by counting the colours of wood only.
    """
    shown = open_page(small_silo_page)
    scale = shown.run("player.view.scale")
    scene = read_scene(reference.path)
    area = perimeter = 0.0
    for _, outlines in scene.outlines(0):
        after = np.roll(outlines, -1, axis=1)
        area += (
            0.5
            * np.abs(
                (outlines[..., 0] * after[..., 1] - after[..., 0] * outlines[..., 1]).sum(axis=1)
            ).sum()
        )
        perimeter += np.linalg.norm(after - outlines, axis=2).sum()
    image = pixels(shown)
    left, bottom = shown.run("player.view.project([player.view.scene.window[0], 0])")
    right = shown.run("player.view.project([player.view.scene.window[1], 0])")[0]
    silo = image[60 : int(bottom) + 20, int(left) + 4 : int(right) - 3]
    wood = (silo[..., 0] > silo[..., 2] + 25).sum()
    assert wood == pytest.approx(area * scale**2 + 0.4 * perimeter * scale, rel=0.05)


def test_colours_follow_the_quantity(small_silo_page, open_page):
    """Each of layer, speed, force and stress gives another picture, with its own legend."""
    shown = open_page(small_silo_page)
    shown.run("player.show(Math.floor(player.frames / 3))")
    names = shown.run("player.data.colours.map(({ label }) => label)")
    assert names == ["layer", "speed", "force", "stress (pressure)"]
    seen = []
    for k in range(len(names)):
        shown.page.locator("#colour").select_option(index=k)
        shown.shown()
        seen.append(pixels(shown)[60:-20])
    for a in range(len(names)):
        for b in range(a):
            assert np.abs(seen[a] - seen[b]).mean() > 1, (names[a], names[b])


def test_the_network_and_the_forces_of_the_walls_are_drawn_and_said(small_silo_page, open_page):
    shown = open_page(small_silo_page)
    before = pixels(shown)
    shown.page.locator("#network").check()
    shown.shown()
    network = pixels(shown)
    blue = (network[..., 2] > network[..., 0] + 60) & (before[..., 2] <= before[..., 0] + 60)
    assert blue.sum() > 300
    assert "forces between bodies" in shown.page.locator("#network-note").inner_text()
    shown.page.locator("#walls").check()
    shown.shown()
    green = (np.abs(pixels(shown) - network).max(axis=2) > 60).sum()
    assert green > 100
    shown.page.locator("#forces-of-walls summary").click()
    shown.shown()
    table = shown.page.locator("#wall-table").inner_text()
    assert "left wall" in table
    assert "N" in table


def test_a_gate_is_drawn_while_it_is_closed(silo_page, open_page):
    """A line from lip to lip, and nothing else, from its first time to its second."""
    shown, pictures = open_page(silo_page), []
    shown.run("player.show(20)")  # 0.2 s
    for times in ([], [0.1, 0.3], [0.1, 0.15]):
        shown.run("(times) => { player.view.scene.gateTimes = times; player.show(20); }", times)
        shown.shown()
        pictures.append(pixels(shown))
    away, closed, open_again = pictures
    lips = np.array(shown.run("player.view.scene.lips.map((at) => player.view.project(at))"))
    rows, columns = np.nonzero(painted(closed, away))
    assert np.ptp(columns) == pytest.approx(np.ptp(lips[:, 0]), abs=6)
    assert np.abs(rows - lips[0, 1]).max() <= 3
    assert not painted(open_again, away).any()


def test_spheres_are_drawn_where_they_are_and_as_large(damper_page, open_page):
    """Of one sphere alone the disc: its area in pixels, its middle to a pixel."""
    shown = open_page(damper_page)
    shown.run(
        "player.view.drawFaces = player.view.drawEdges = () => {};"
        "player.view.marks.draw = () => {};"
        "player.view.radii.fill(0); player.view.radii[7] = player.arrays.radius.at(7);"
    )
    shown.shown("player.redraw()")
    image = pixels(shown)[40:-80]  # without the words
    rows, columns = np.nonzero(painted(image))
    radius = shown.run("player.arrays.radius.at(7) * player.view.scale")
    # Pixels whose middle lies in it; the brim of those counts as a quarter of a pixel all round.
    assert len(rows) == pytest.approx(np.pi * (radius + 0.25) ** 2, rel=0.03)
    x, y, _ = shown.run("player.view.project(player.view.place(7, 0))")
    assert (columns.mean(), rows.mean() + 40) == pytest.approx((x, y), abs=1.5)


def mask_of(image: np.ndarray, shapes: list[tuple[str, list]]) -> np.ndarray:
    """Mask, of the size of a picture, of polygons (corners) and discs (middle, radius) [px]."""
    drawn = Image.new("1", image.shape[1::-1])
    for kind, points in shapes:
        if kind == "polygon":
            ImageDraw.Draw(drawn).polygon([tuple(point) for point in points], fill=1)
        else:
            (x, y), r = points
            ImageDraw.Draw(drawn).ellipse((x - r, y - r, x + r, y + r), fill=1)
    return np.asarray(drawn)


def common(a: np.ndarray, b: np.ndarray) -> float:
    """Part of two masks together that both cover."""
    return float((a & b).sum() / (a | b).sum())


def test_a_polygon_is_drawn_as_it_lies(small_silo_page, reference, open_page):
    """One alone, eight times as large: the pixels are those of its outline as the scene has it.

    Its edge is half a line of 0.8 px wider and shares its outermost pixels with the paper: two
    pixels outside nothing is painted, two pixels inside all is.
    """
    scene = read_scene(reference.path)
    shown = open_page(small_silo_page)
    for particle in (5, 23, 40):
        shown.run(
            "(k) => { const { view } = player; view.shows = (one) => one === k; view.fit();"
            " player.arrays.inside.integers.fill(0); player.arrays.inside.integers[k] = 1;"
            " view.drawWalls = view.marks.draw = () => {};"
            " view.zoom(8); view.lookAt(view.centreOf(k, 0)); player.redraw(); }",
            particle,
        )
        shown.shown()
        image = pixels(shown)
        ((_, outline),) = [(w, o) for w, o in scene.placed(0, np.array([particle])) if len(w)]
        corners = shown.run("(points) => points.map((p) => player.view.project(p))",
                            outline[0].tolist())  # fmt: skip
        wanted = mask_of(image, [("polygon", corners)])
        inside, near = binary_erosion(wanted, iterations=2), binary_dilation(wanted, iterations=2)
        between = slice(60, -80)  # the words above and below, which a large one may reach
        assert inside[between].sum() > 3000, particle
        assert painted(image)[between][inside[between]].all(), particle
        assert not painted(image)[between][~near[between]].any(), particle


def test_a_small_disc_is_drawn_round(small_silo_page, open_page):
    """Corners are left out up to the 0.3 px that the outline may lie off, all of them together:
    of a disc of 7 px, whose chords lie r (1 - cos(pi/n)) inside, there must be eleven at least.
    """
    shown = open_page(small_silo_page)
    angle = np.linspace(0.0, 2 * np.pi, 64, endpoint=False)
    circle = 7.0 * np.column_stack([np.cos(angle), np.sin(angle)])  # [px]
    drawn = shown.run(
        "(circle) => { const { view } = player, found = [];"
        " view.scene.outlines = [circle.map((p) => p.map((c) => c / view.scale / view.ratio))];"
        " for (const name of ['moveTo', 'lineTo'])"
        "   Path2D.prototype[name] = (x, y) => found.push([x, y]);"
        " view.simplify();"
        " return found.map((p) => p.map((c) => c * view.scale * view.ratio)); }",
        circle.tolist(),
    )
    assert 11 <= len(drawn) < 32
    assert hausdorff_distance(Polygon(circle).exterior, Polygon(drawn).exterior) <= 0.3 + 1e-6


@pytest.mark.parametrize("name", ["clusters_page", "mixture_page"])
def test_multi_sphere_particles_are_drawn_as_they_lie(name, request, open_page):
    """One alone, enlarged: the pixels are those of its sub-spheres' discs, turned as it is.

    The mesh cuts corners between its triangles: some per cent of the area. The last two of a
    mixture are of another shape, in two sizes.
    """
    page = request.getfixturevalue(name)
    scene = damper_scene(page.parent / "made")
    shown = open_page(page)
    last = len(scene.radius) - 1
    for particle, frame in ((4, 0), (11, 7), (last - 1, 13), (last, 2)):
        shown.run(
            "([k, frame]) => { const { view } = player; view.fromTheNearest = () => [k];"
            " view.count = 1; view.drawFaces = view.drawEdges = view.marks.draw = () => {};"
            " player.show(frame); view.fit(); view.zoom(6); view.lookAt(view.place(k, frame)); }",
            [particle, frame],
        )
        shown.shown()
        image = pixels(shown)
        image[:60] = image[-80:] = 255
        arm, radius, whose = scene.spheres(frame)
        centre = scene.particles(frame).position[whose] + arm + scene.shift(frame)
        places = shown.run("(points) => points.map((p) => player.view.project(p))",
                           centre[whose == particle].tolist())  # fmt: skip
        scale = shown.run("player.view.scale")
        discs = [("disc", [place[:2], scale * r])
                 for place, r in zip(places, radius[whose == particle], strict=True)]  # fmt: skip
        wanted = mask_of(image, discs)
        assert wanted.sum() > 2000
        assert common(painted(image), wanted) > 0.93, particle


def test_a_cut_shows_what_is_inside(damper_page, open_page):
    """The front taken away in the middle: spheres before it are gone, and no longer picked."""
    shown = open_page(damper_page)
    whole = pixels(shown)
    shown.page.locator("#cut").select_option("nearer")
    shown.shown()
    cut = pixels(shown)
    assert np.abs(cut - whole).max() > 60
    hidden = shown.run(
        "(() => { const { count, scene } = player.view; const out = [];"
        " const plane = player.view.cutPlane();"
        " for (let k = 0; k < count; k++) { const c = player.view.centreOf(k, 0);"
        " const ahead = c.reduce((s, v, a) => s + v * plane.normal[a], 0) - plane.offset;"
        " if (ahead > player.view.radii[k]) out.push(k); } return out; })()"
    )
    assert len(hidden) > 10
    for particle in hidden:
        at = shown.run("(k) => player.view.project(player.view.place(k, 0)).slice(0, 2)", particle)
        assert shown.run("(at) => player.view.pick(at, 0)", at) != particle


def test_the_enclosure_moves_in_the_laboratory_and_rests_in_its_own_frame(damper_page, open_page):
    """Its displacement a quarter of a cycle on, Gamma g/w^2 = 3.1 mm, in pixels, or none."""
    shown = open_page(damper_page)
    quarter = shown.run("Math.round(player.frames / 20)")  # eight frames a cycle, five cycles
    up = {}
    for lab in (True, False):
        shown.page.locator("#lab").set_checked(lab)
        ends = [
            shown.run("(k) => player.view.project(player.view.onEnclosure([0, 0, 0], k))[1]", k)
            for k in (0, quarter)
        ]
        up[lab] = ends[0] - ends[1]
    stroke = shown.run(
        "(k) => Math.hypot(...[0, 1, 2].map((a) => player.arrays.shift.at(k, a)))", quarter
    )
    scale = shown.run("player.view.scale * player.view.camera[1][2]")
    assert stroke == pytest.approx(20 * 9.81 / (80 * np.pi) ** 2, rel=1e-3)
    assert up[True] == pytest.approx(stroke * scale, rel=1e-3)
    assert up[False] == 0


def test_orbiting_turns_and_never_goes_over_the_top(damper_page, open_page):
    shown = open_page(damper_page)
    box = stage_of(shown)
    shown.page.mouse.move(box["x"] + 300, box["y"] + 200)
    shown.page.mouse.down()
    shown.page.mouse.move(box["x"] + 390, box["y"] + 900, steps=6)
    shown.page.mouse.up()
    camera = np.array(shown.run("player.view.camera"))
    np.testing.assert_allclose(camera @ camera.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(camera) == pytest.approx(1.0)
    assert camera[2, 2] == pytest.approx(1.0), "from above, gravity away from the eye"


@pytest.mark.parametrize("name", ["small_silo_page", "small_damper_page", "clusters_page"])
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_light_and_dark_pages_are_legible(name, scheme, request, open_page):
    """Ink on paper by the contrast ratio of WCAG 2.1: at least 7 to 1; quiet words 4.5 to 1."""
    shown = open_page(request.getfixturevalue(name), scheme=scheme)
    colours = shown.run(
        "['paper', 'stage', 'ink', 'quiet'].map((name) => getComputedStyle(document"
        ".documentElement).getPropertyValue(`--${name}`).trim())"
    )
    paper, stage, ink, quiet = map(luminance, colours)
    for ground in (paper, stage):
        assert contrast(ink, ground) > 7
        assert contrast(quiet, ground) > 4.5
    assert (np.median(pixels(shown)) > 128) == (scheme == "light")


def luminance(colour: str) -> float:
    """Relative luminance of a colour #rrggbb (WCAG 2.1)."""
    channels = np.array([int(colour[k : k + 2], 16) for k in (1, 3, 5)]) / 255
    linear = np.where(channels <= 0.04045, channels / 12.92, ((channels + 0.055) / 1.055) ** 2.4)
    return float(linear @ [0.2126, 0.7152, 0.0722])


def contrast(a: float, b: float) -> float:
    """Contrast ratio of two luminances (WCAG 2.1)."""
    return (max(a, b) + 0.05) / (min(a, b) + 0.05)


@pytest.mark.parametrize("name", ["small_silo_page", "small_damper_page"])
def test_a_phone_s_width_needs_no_scrolling_aside(name, request, open_page):
    shown = open_page(request.getfixturevalue(name), size=(360, 740))
    assert shown.run("document.documentElement.scrollWidth") <= 360
    wide = shown.run(
        "[...document.querySelectorAll('button, select, input, canvas, table')].filter((node) =>"
        " node.offsetParent && node.getBoundingClientRect().right > 361).map((node) => node.id)"
    )
    assert wide == []
    assert shown.page.locator("#stage").bounding_box()["height"] > 250


@pytest.mark.parametrize("name", ["silo_page", "damper_page", "clusters_page"])
def test_pictures_are_those_that_were_looked_at(name, request, open_page):
    """Loosely: blocks of 24 x 24 pixels of the stage differ by a fifth of what they are from paper.

    GRANULAB_WRITE_PICTURES=1 writes them anew, to be looked at.
    """
    shown = open_page(request.getfixturevalue(name), size=(900, 700))
    shown.run("player.show(12)")
    shown.shown()
    image = Image.fromarray(pixels(shown).astype(np.uint8))
    blocks = image.resize((image.width // 24, image.height // 24), Image.Resampling.BOX)
    path = Path(__file__).parent / "pictures" / f"{name}.png"
    if os.environ.get("GRANULAB_WRITE_PICTURES"):
        path.parent.mkdir(exist_ok=True)
        blocks.save(path)
    kept = Image.open(path).convert("RGB")
    assert kept.size == blocks.size
    kept_pixels, pixels_now = (np.asarray(one).astype(float) for one in (kept, blocks))
    from_paper = np.abs(kept_pixels - 255.0).mean()
    assert from_paper > 10, "a picture of something"
    assert np.abs(kept_pixels - pixels_now).mean() < 0.2 * from_paper
