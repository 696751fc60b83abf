"""
The largest stable time step
============================

Where does the leapfrog of the silo become unstable? For one spring and dashpot, x'' + gamma x' +
omega^2 x = 0, at (omega dt)^2 + 4 gamma dt = 4, where its root passes -1.

On the command line, for all contacts of the stiffest configuration at once::

    $ silo2d run A4 --dry-run
      time step   5e-06 s: the usual one; stable up to 5.91 us ...
"""

import matplotlib.pyplot as plt

from granulab.contact.timestep import stable_time_step


# %%
# Damping from the velocity extrapolated by half a step, as in the engine.
def swings(step, omega2, gamma, number=400):
    x, v, before = 1.0, 0.0, 0.0
    sizes = []
    for _ in range(number):
        force = -omega2 * x - gamma * (v + 0.5 * step * before)
        before = force
        v += step * force
        x += step * v
        sizes.append(abs(x))
    return sizes


# %%
# A particle of the wood silo (mass 10.8 g) on one contact: kn 1e4 N/mm, gamma_n 6085 1/s.
omega2, gamma = 1e7 / 0.0108, 6085.0
largest = stable_time_step(omega2, gamma)
for share in (0.8, 0.99, 1.01):
    plt.semilogy(swings(share * largest, omega2, gamma), label=f"{share} of the largest step")
plt.gca().set(xlabel="steps [-]", ylabel="displacement over that at the start [-]")
plt.legend()

# %%
# At the largest step the root is -1: once the other one has died away each swing is as large as
# the last, to the round-off of 400 steps.
sizes = swings(largest, omega2, gamma)
print(f"largest step {1e6 * largest:.2f} us")
assert abs(sizes[-1] / sizes[-2] - 1) < 1e-12
