"""The ground that all of GranuLab stands on: contact laws and parameters, runs and sweeps."""
