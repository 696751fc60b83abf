"""Clogging by outlet as a picture and in words."""
