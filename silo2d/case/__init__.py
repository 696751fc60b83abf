"""Cases of silos: files and options resolved to shapes, outline, laws and time step."""
