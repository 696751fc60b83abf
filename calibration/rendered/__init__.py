"""Rendered films of known truth: what a camera would see of a scene that is computed."""
