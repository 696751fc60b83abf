"""
Faces rebound less than corners
===============================

How much less does a particle rebound when it lands on a face? n vertex-edge contacts in parallel
act as one with n kn and n gamma (wood-silo paper, eqs 3.8 to 3.10).

On the command line::

    $ silo2d run A4 --dry-run
      restitution particle-particle 0.80 for one contact, 0.53 face to face; ...
"""

import matplotlib.pyplot as plt
import numpy as np
from scipy.integrate import solve_ivp

from granulab.contact.restitution import linear_restitution

# %%
# Table 4 of the paper: kn 1e4 N/mm, gamma_n 6085 1/s; two mean particles of 10.43 g.
kn, gamma, mass = 1e7, 6085.0, 0.01043 / 2
contacts = np.arange(1, 13)
for end in ("overlap", "force"):
    plt.plot(contacts, [linear_restitution(gamma, kn, mass, end=end, contacts=int(n))
                        for n in contacts], "o-", label=f"ends at zero {end}")  # fmt: skip
plt.gca().set(xlabel="contacts in parallel [-]", ylabel="restitution [-]", ylim=(0, 1))
plt.legend()


# %%
# Eight contacts, face to face, as one, integrated from the first touch until the overlap is zero
# again; the tolerance is a thousand times that of the integration.
def motion(_time, state):
    return state[1], -8 * gamma * state[1] - 8 * kn / mass * state[0]


def parted(time, state):
    return state[0] if time > 0 else 1.0


parted.terminal, parted.direction = True, -1
end = solve_ivp(motion, (0, 1), (0.0, 1.0), events=parted, rtol=1e-9, atol=1e-15).y[1, -1]
print(f"{linear_restitution(gamma, kn, mass):.2f} for one contact, {-end:.2f} face to face")
assert abs(linear_restitution(gamma, kn, mass, contacts=8) + end) < 1e-6
