"""Many dampers of spheres at once: each has a slot, and all slots go on together, on a GPU.

In the order of the data: slots.py holds the arrays of all slots, and brings the world of a damper
into one and back; step.py takes one step of a slot, by as many threads as there are; samples.py
writes its samples; loop.py goes on from sample to sample, lists included; device.py is the only
part that knows a GPU. What they compute is what the engine of one bed computes, with the same laws.
"""
