"""The efficiency over frequency and Gamma: runs on a grid, peaks, ridges, picture and tables."""

from damper3d.studies.map.grid import efficiency_map

__all__ = ["efficiency_map"]
