"""Prisms in line contact: their stiffness from Young's modulus and Poisson's ratio, and back."""
