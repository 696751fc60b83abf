"""Shapes of particles as rigid clusters of sub-spheres: one file per family (thesis, chapter 4)."""
