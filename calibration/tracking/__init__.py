"""Tracks of objects in films: found, linked, followed and cut into segments."""
