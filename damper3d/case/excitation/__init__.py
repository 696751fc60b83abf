"""Excitations that are no single sine: sums of sines, sweeps, random, shocks, measured signals."""
