"""Restitution from objects that swing on strings and collide: paper eq. 3.6."""
