"""Drawings and photographs as outlines: SVG, DXF and pictures to silos and shapes of particles."""
