"""The engine of the silo: state, geometry, neighbours, forces, motion, and the step loop.

Kernels and the only callers of kernels. Nothing of the project is imported here but the contact
laws and the errors; a case reaches the engine as arrays.
"""

from pathlib import Path

ENGINE = Path(__file__).parent  # by which its compiled kernels are kept
