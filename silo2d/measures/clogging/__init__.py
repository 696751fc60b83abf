"""Clogging as statistics: sizes of avalanches, laws of the outlet, waiting times, arches."""
