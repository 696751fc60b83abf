"""Energy account of a tangential spring (contact/hertz.py): friction and work of its law.

Its stiffness k changes with the overlap, so that its energy changes without work. In a step from
b to n the trial displacement (or force) is what the spring would hold if it did not slip, and k the
mean of k_b and k_n. With F = k s:

    stored displacement   E_n - E_b = (F_b + F_n)/2 (s_n - s_b) + (k_n - k_b) s_b s_n/2
    stored force          E_n - E_b = (F_b + F_n)/2 (F_n - F_b)/k
                                      + F_n^2 (1/k_n - 1/k)/2 - F_b^2 (1/k_b - 1/k)/2

are identities: work of the mean force over the spring's displacement, and work of the changing
stiffness. The rest of the trial, the slip, is friction's. So the energy balance of a contact closes
as its motion does, to second order in the step, also where the spring begins with much displacement
and no stiffness (a damped normal force lets it slide at once: s ~ mu f_n/kt is then unbounded, at
finite energy).
"""

from granulab.contact.jit import njit
from granulab.contact.vectors import add, dot, scale


@njit
def spring_account(law, kt_before, kt, held_before, trial, held):
    """Energy [J] lost to friction in a step, and the work of the changing stiffness.

    kt_before, kt: tangential stiffness at both ends of the step [N/m]; held_before, held: what the
    spring holds there, trial: what it would hold without slip; tuples of three, displacements [m],
    or forces [N] where the law stores these.
    """
    slip = add(trial, scale(-1.0, held))
    if law.stored_force:
        if kt == 0.0:
            return 0.0, 0.0
        mean = 0.5 * (kt_before + kt)
        rubbed = 0.5 * dot(add(held_before, held), slip) / mean
        gained = 0.5 * dot(held, held) * (1.0 / kt - 1.0 / mean)
        if kt_before > 0.0:
            gained -= 0.5 * dot(held_before, held_before) * (1.0 / kt_before - 1.0 / mean)
        return rubbed, gained
    force = add(scale(kt_before, held_before), scale(kt, held))
    return 0.5 * dot(force, slip), 0.5 * (kt - kt_before) * dot(held_before, held)
