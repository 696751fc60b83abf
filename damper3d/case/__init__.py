"""Cases of dampers: files and options resolved to particles, laws, motion and time step."""
