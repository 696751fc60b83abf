"""Closed surfaces: triangles, distances, volumes, and the filling with sub-spheres."""
