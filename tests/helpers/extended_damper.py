"""A damper whose enclosure and motion come from outside the package, in a process of its own.

A kind of enclosure and one of motion make an engine of their own; with both in one case it is
compiled once. Run with the folder of test_extend_enclosure.py and test_extend_motion.py.
"""

import json
import sys
import tempfile

sys.path.insert(0, sys.argv[1])

import test_extend_enclosure as enclosure
import test_extend_motion as motion

from damper3d import DamperCase, run
from damper3d.run import fill


def main() -> None:
    """Fill a cone, shake it along parabolas, and say what became of it."""
    enclosure.register()
    motion.register()
    fill.at_rest = lambda: motion.Parabolas(0.0, 1.0, 0.0)  # fills with the engine that shakes
    case = DamperCase.load("thesis", enclosure.CASE | motion.CASE)
    with tempfile.TemporaryDirectory() as out:
        result = run(case, out=out)
        found = {
            "closure": result.energy_closure, "efficiency": result.efficiency_with_settling,
            "enclosure": enclosure.found(case, result, out), "motion": motion.found(case, result),
        }  # fmt: skip
    print(json.dumps(found))


if __name__ == "__main__":
    main()
