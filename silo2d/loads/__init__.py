"""Loads on silos in closed form: Janssen, EN 1991-4:2006 and Jenike; they know no run."""
