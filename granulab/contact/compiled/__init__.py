"""Compiled kernels: their files on disk, threads that run one together, and what these share."""
