"""A shaken record: the power that a bed dissipates, from force and acceleration."""
