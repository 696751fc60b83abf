"""Miniature triaxial test (sec. 3.2): stiffness of an inclined contact, from markers on film."""
