"""Specialisations for particles of one sphere: pairs, walls, motion, growth, impact."""
