"""The arrays that the kernels work on: bodies, spheres, walls, lists of pairs, books.

A particle is a rigid cluster of spheres; a sphere is a cluster of one. What moves is a body, what
touches is a sphere, and a sphere knows its body. Vectors stand in rows of four numbers: the fourth
of a position is the radius, so that one load brings all, and the others' is unused.
"""
