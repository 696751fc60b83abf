"""The ideal efficiency against Gamma: a panel for each fill, a colour for each frequency."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from damper3d.case import closed_forms
from damper3d.studies.predict.prediction import Prediction
from granulab.campaign.output.figure import (
    BLUE,
    GREEN,
    GREY,
    INK,
    ORANGE,
    PURPLE,
    SKY,
    VERMILION,
    headline,
    ruled,
    ticked,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_COLOURS = (VERMILION, BLUE, GREEN, ORANGE, PURPLE, SKY, INK)
_STYLES = {"loose": (0, (4, 2)), "close": "-", "own": (0, (1, 1)), "counted": (0, (4, 1, 1, 1))}
_TICKS = (0.5, 1, 2, 5, 10, 20, 50, 100, 200)

Rows = Sequence[dict[str, Any]]


def draw_predictions(
    predictions: Sequence[Prediction], frequencies: Sequence[float], simulated: Rows = ()
) -> "Figure":
    """Ideal curves from their onsets on, lines at the other onsets, and runs as points.

    `simulated` has a row a run: fill (index of the prediction), frequency_hz, gamma, efficiency.
    """
    from matplotlib.figure import Figure

    columns = 1 if len(predictions) == 1 else 2
    rows = -(-len(predictions) // columns)
    figure = Figure(figsize=(4.2 * columns + 2.2, 2.9 * rows + 0.8), layout="constrained")
    headline(figure, "Efficiency that closed forms predict")
    panels = figure.subplots(rows, columns, squeeze=False, sharex=True, sharey=True)
    for k, (axes, prediction) in enumerate(zip(panels.flat, predictions, strict=False)):
        _panel(axes, prediction, frequencies)
        for row in simulated:
            if row["fill"] == k and row.get("efficiency") is not None:
                _point(axes, row, frequencies)
    for axes in list(panels.flat)[len(predictions) :]:
        axes.set_visible(False)
    for axes in panels[-1]:
        axes.set_xlabel("Γ [-]")
    for axes in panels[:, 0]:
        axes.set_ylabel("efficiency [-]")
    handles, labels = panels.flat[0].get_legend_handles_labels()
    if simulated:
        handles.append(panels.flat[0].plot([], [], "o", color=GREY, mec=INK)[0])
        labels.append("simulated")
    figure.legend(handles, labels, loc="outside right upper")
    return figure


def _panel(axes: "Axes", prediction: Prediction, frequencies: Sequence[float]) -> None:
    ruled(axes)
    best = prediction.best
    for frequency, colour in zip(frequencies, _cycle(frequencies), strict=True):
        for clearance in prediction.clearances:
            onset = clearance.onset(frequency)
            if onset is not None and clearance is not best:
                axes.axvline(
                    onset, color=colour, ls=_STYLES[clearance.name], lw=1,
                    label=f"onset, {clearance.name}" if colour == _COLOURS[0] else None,
                )  # fmt: skip
        onset = best.onset(frequency)
        if onset is not None:
            ratio = np.geomspace(1, max(200 / onset, 2), 300)
            eta = closed_forms.collect_and_collide(ratio)
            axes.plot(
                onset * np.array([1, *ratio]), [0, *eta], color=colour,
                label=f"bouncing bed, {frequency:g} Hz\n({best.name} packing)",
            )  # fmt: skip
    if prediction.fluidisation:
        gamma = np.linspace(1, closed_forms.PERIOD_DOUBLING, 200)
        axes.plot(gamma, closed_forms.inelastic_block(gamma), color=INK, lw=1,
                  label="block without rebound,\nno lid")  # fmt: skip
    elif prediction.threshold:
        axes.axvline(prediction.threshold, color=INK, lw=1, label="onset of motion")
    fill, length = prediction.fill_ratio, 1e3 * prediction.length
    axes.set_title(
        f"fill ratio {fill:.3f}, {length:g} mm, {prediction.orientation}", loc="left", fontsize=9
    )
    axes.set(xscale="log", ylim=(0, 1.03), xlim=(0.4, 200))
    ticked(axes, _TICKS)


def _point(axes: "Axes", row: dict[str, Any], frequencies: Sequence[float]) -> None:
    colour = _cycle(frequencies)[list(frequencies).index(row["frequency_hz"])]
    axes.plot(row["gamma"], row["efficiency"], "o", color=colour, mec=INK, mew=0.6, ms=5, zorder=5)


def _cycle(frequencies: Sequence[float]) -> list[str]:
    return [_COLOURS[k % len(_COLOURS)] for k in range(len(frequencies))]
