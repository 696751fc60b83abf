"""Reduced quantities of a pair of bodies."""

from contact.jit import njit


@njit
def reduced_mass(inverse_mass_i, inverse_mass_j):
    """m_i m_j / (m_i + m_j) [kg], from inverse masses [1/kg]: a wall has inverse mass zero."""
    return 1.0 / (inverse_mass_i + inverse_mass_j)
