"""
Displacement between two pictures
=================================

How far has a bed of particles moved from one picture to the next, and how well is that known? Two
made pictures of one texture, 3.4 px apart along x and -1.7 px along y (correlation in windows
that are deformed, Scarano 2002; sigma by Wieneke 2015).

On the command line, with the pictures that this script writes::

    $ calibrate piv a.png b.png --window 32
    u          3.4...
"""

import cv2
import matplotlib.pyplot as plt
import numpy as np

from calibration.piv import displacement

# %%
# Spots at random positions, drawn at both of theirs.
rng = np.random.default_rng(1)
centres = rng.uniform(-10, 210, (1500, 2))
x, y = np.meshgrid(np.arange(200), np.arange(200))
shift = np.array([3.4, -1.7])  # [px]
pictures = []
for moved in (-0.5 * shift, 0.5 * shift):
    picture = np.zeros((200, 200))
    for across, down in centres + moved:
        left, top = int(max(across - 8, 0)), int(max(down - 8, 0))
        part = np.s_[top : int(down + 9), left : int(across + 9)]
        picture[part] += np.exp(-((x[part] - across) ** 2 + (y[part] - down) ** 2) / (2 * 1.5**2))
    pictures.append(np.uint8(np.clip(100 * picture + rng.normal(20, 2, picture.shape), 0, 255)))
for name, picture in zip("ab", pictures, strict=True):
    cv2.imwrite(f"{name}.png", picture)

# %%
field = displacement(*pictures, window=32)
plt.imshow(pictures[0], cmap="gray", alpha=0.5)
plt.quiver(field.x, field.y, field.u, field.v, angles="xy")
plt.gca().set(xlabel="x [px]", ylabel="y [px]")

# %%
# The mean of the vectors is the shift. Windows that overlap by half share their spots, so that
# one vector in four counts as independent: four of its standard errors hold the mean.
good = field.valid
error = field.u[good].std() / np.sqrt(good.sum() / 4)
print(f"u {field.u[good].mean():.3f} px, v {field.v[good].mean():.3f} px")
assert abs(field.u[good].mean() - 3.4) < 4 * error
