"""A measure of one's own: by how much the bed's height varies while it is shaken."""

from matplotlib.figure import Figure

from damper3d import DamperCase, register_measure, run
from granulab.campaign import read_trajectory
from granulab.campaign.output.measures import Measure


def spread(folder):
    height = read_trajectory(folder)["mean_position"][:, 2]
    return {"spread_m": float(height.std()), "mean_m": float(height.mean())}


def draw(folder):
    figure = Figure()
    figure.subplots().plot(read_trajectory(folder)["mean_position"][:, 2])
    return figure


register_measure("spread", Measure("scatter of the bed's height", "m", spread, draw))

if __name__ == "__main__":
    result = run(DamperCase.load("thesis", {"motion.gamma": 5}))
    print(spread(result.run_folder))
