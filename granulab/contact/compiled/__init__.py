"""Compiled kernels: their files on disk, and threads that run one together."""
