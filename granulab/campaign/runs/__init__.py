"""One run: its folder, lock, provenance, frames, checkpoints and result."""
