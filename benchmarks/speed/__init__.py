"""Speed in one table: scenes, what they cost here and in other engines, and the bound of the core.

    python -m benchmarks.speed [--only WORD] [--write FOLDER] [--check]

`make bench` prints it. CPU time of one core; stretches of all engines take turns, so that a machine
that others use is unfair to all alike: ratios hold elsewhere, seconds do not.
"""
