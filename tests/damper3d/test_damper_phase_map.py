"""The map of phases: where its markers stand, what its cells cover, what it refuses."""

import pytest
from matplotlib.figure import Figure

from damper3d.measures.phases.criteria import PHASES
from damper3d.measures.phases.phase_map import draw_phase_map, phases_of_points
from granulab.errors import InputError

ROWS = [
    {"frequency_hz": 40.0, "gamma": 1.0, "phase": "solid_like"},
    {"frequency_hz": 40.0, "gamma": 20.0, "phase": "bouncing_bed"},
    {"frequency_hz": 160.0, "gamma": 1.0, "phase": "global_fluidisation"},
    {"frequency_hz": 160.0, "gamma": 20.0, "phase": "transition"},
    {"frequency_hz": 160.0, "gamma": 20.0, "phase": "leidenfrost"},
    {"frequency_hz": 160.0, "gamma": 20.0, "phase": "leidenfrost"},
    {"frequency_hz": 160.0, "gamma": 40.0, "phase": None},
]


def test_a_point_has_the_phase_of_most_of_its_packings():
    points = phases_of_points(ROWS)
    assert points[160.0, 20.0] == ("leidenfrost", pytest.approx(2 / 3))
    assert points[40.0, 1.0] == ("solid_like", 1.0)
    assert (160.0, 40.0) not in points


@pytest.mark.parametrize("areas", [False, True])
def test_markers_stand_at_their_points_in_the_order_of_the_phases(areas):
    axes = Figure().subplots()
    draw_phase_map(axes, ROWS, "vertical", areas=areas)
    labels = axes.get_legend_handles_labels()[1]
    order = [look.label for look in PHASES["vertical"].values()]
    assert labels == [label for label in order if label in labels]
    assert len(labels) == 4
    first = next(c for c in axes.collections if c.get_label() == "bouncing bed")
    assert first.get_offsets().tolist() == [[40.0, 20.0]]


def test_cells_meet_half_way_in_the_logarithm():
    """Between 40 and 160 Hz: 80 Hz; the outer ends as far away again."""
    axes = Figure().subplots()
    draw_phase_map(axes, ROWS, "vertical", areas=True)
    assert axes.get_xlim()[0] <= 20.0 * 1.001
    corners = [
        mesh.get_coordinates() for mesh in axes.collections if hasattr(mesh, "get_coordinates")
    ]
    edges = sorted({float(x) for corner in corners for x in corner[..., 0].ravel()})
    assert edges == pytest.approx([20.0, 80.0, 320.0])


def test_a_phase_of_another_orientation_is_refused_with_those_there_are():
    with pytest.raises(InputError, match="partial_fluidisation"):
        draw_phase_map(Figure().subplots(), ROWS, "horizontal")
