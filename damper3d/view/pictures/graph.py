"""What the graphs of dampers share: thin lines behind, legends beside."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def ruled(axes: "Axes") -> None:
    """Thin horizontal lines behind what is drawn."""
    axes.grid(axis="y", color="#e6e3dc", lw=0.7)
    axes.set_axisbelow(True)


def legend_beside(axes: "Axes", *handles_and_labels: list, right: float = 1.01) -> None:
    """A legend to the right of the axes, where it hides nothing: at `right` of their width."""
    axes.legend(*handles_and_labels, loc="upper left", bbox_to_anchor=(right, 1), labelspacing=0.6)
