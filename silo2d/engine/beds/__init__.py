"""Kernels of what a run may have besides: friction of the plates, walls that vibrate.

A world without them has None in their place; its type leaves them out when a kernel is compiled.
"""
