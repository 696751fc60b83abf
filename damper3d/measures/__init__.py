"""Measures of finished runs: efficiency, response, phases; and the registry of all.

Functions of run folders, never of the live world. See granulab.campaign.output.measures for adding
one: a module here and a line below, or `damper3d.register_measure` from outside.
"""

from granulab.campaign.output.measures import Measures, Shipped

# Name as in `damper3d observe RUN WHAT`.
MEASURES = Measures(
    {
        "efficiency": Shipped(
            "damping efficiency of each cycle, and the share of each mechanism",
            "1",
            "damper3d.measures.efficiency",
        ),
        "excitation": Shipped(
            "motion that is no single sine: sweeps by frequency, spectra",
            "1",
            "damper3d.measures.excitation",
        ),
        "host": Shipped(
            "response of the host that the enclosure rides on, with the damper and bare",
            "m",
            "damper3d.measures.host",
        ),
        "phases": Shipped(
            "motional phase, and the measures of the motion that it is named from",
            "1",
            "damper3d.measures.phases",
        ),
        "response": Shipped(
            "dissipated power, loss factor, equivalent damper and effective mass",
            "W",
            "damper3d.measures.response",
        ),
    }
)

register, observe, draw = MEASURES.register, MEASURES.observe, MEASURES.draw
