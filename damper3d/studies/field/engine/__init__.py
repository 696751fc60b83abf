"""The engine room of the harmonic balance of several dampers: its equations and solution curves."""

from pathlib import Path

BALANCE = Path(__file__).parent  # by which its compiled kernels are kept
