"""A bed in YADE that takes commands line by line: "run N", "start", "cpu" or "end".

Runs in YADE's own Python: `yade -n -j1 yade_bed.py SCENE.json`. After each command it prints "cpu"
and the CPU time of its process so far [s].
"""

import json
import math
import sys
import time
from pathlib import Path

from yade import geom, utils, wrapper

FACETS = 36  # of the round wall

scene = json.loads(Path(sys.argv[1]).read_text())
omega = wrapper.Omega()
material = wrapper.FrictMat(
    young=scene["young"], poisson=scene["poisson"], density=scene["density"],
    frictionAngle=math.atan(scene["friction"]), label="acrylic",
)  # fmt: skip
omega.materials.append(material)
omega.bodies.append([
    utils.sphere(centre, scene["radius"], material="acrylic") for centre in scene["position"]
])  # fmt: skip
radius, height = scene["enclosure"]
walls = omega.bodies.append([
    utils.wall(0.0, axis=2, material="acrylic"),
    utils.wall(height, axis=2, material="acrylic"),
    *geom.facetCylinder(
        (0, 0, height / 2), radius, 2 * height, wallMask=4, segmentsNumber=FACETS,
        material="acrylic",
    ),
])  # fmt: skip
restitution = wrapper.MatchMaker(algo="val", val=scene["restitution"])
shaker = wrapper.HarmonicMotionEngine(
    A=(0, 0, scene["amplitude"]), f=(0, 0, scene["omega"] / (2 * math.pi)), fi=(0, 0, -math.pi / 2),
    ids=walls, dead=True,
)  # fmt: skip
omega.engines = [
    wrapper.ForceResetter(),
    wrapper.InsertionSortCollider(
        [wrapper.Bo1_Sphere_Aabb(), wrapper.Bo1_Facet_Aabb(), wrapper.Bo1_Wall_Aabb()],
        verletDist=0.05 * scene["radius"],
    ),
    wrapper.InteractionLoop(
        [
            wrapper.Ig2_Sphere_Sphere_ScGeom(),
            wrapper.Ig2_Facet_Sphere_ScGeom(),
            wrapper.Ig2_Wall_Sphere_ScGeom(),
        ],
        [wrapper.Ip2_FrictMat_FrictMat_MindlinPhys(en=restitution, es=restitution)],
        [wrapper.Law2_ScGeom_MindlinPhys_Mindlin()],
    ),
    shaker,
    wrapper.NewtonIntegrator(damping=0, gravity=scene["gravity"]),
]
omega.dt = scene["time_step"]

for line in sys.stdin:
    command, *number = line.split()
    if command == "end":
        break
    if command == "run":
        omega.run(int(number[0]), True)
    if command == "start":
        shaker.fi = (0, 0, -math.pi / 2 - scene["omega"] * omega.time)
        shaker.dead = False
    print("cpu", time.process_time(), flush=True)
