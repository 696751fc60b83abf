"""Rebound of an irregular particle, with its rotation: restitution at the point of contact."""
