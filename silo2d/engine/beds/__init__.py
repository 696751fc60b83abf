"""Kernels of what a run may have besides: plates that rub, walls that vibrate, a drawn door.

A world without them has None in their place; its type leaves them out when a kernel is compiled.
"""
