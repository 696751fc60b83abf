"""Cost of responses that follow from a field: 1,000 of them, levels times hosts.

    python benchmarks/responses.py [--field field.csv]

Each is a structure's whole curve: all solutions at 400 frequencies across its resonance. Without a
field one is made up, of 3 frequencies with 24 Gammas. Prints the seconds of CPU; under one is
asked. Then the same of two dampers on two modes, whose solutions are followed, without compiling.
"""

import argparse
import time
from collections.abc import Iterable

import numpy as np

from damper3d.studies.field.balance import Responses, respond
from damper3d.studies.field.several import respond_together
from damper3d.studies.field.structure import Structure
from damper3d.studies.field.table import Field, read_field

HOSTS, LEVELS, FREQUENCIES = 20, 50, 400


def made_up() -> Field:
    """A bed of 30 g that rides up to Gamma 1 and falls off beyond."""
    frequency = np.repeat([20.0, 40.0, 80.0], 24)
    gamma = np.tile(np.geomspace(0.5, 60.0, 24), 3)
    x = np.minimum(1.0 / gamma, 1.0)
    return Field.of(frequency, gamma, 0.03 * (x**1.5 - 2j * x * (1 - x)), 0.03)


def main() -> None:
    """Time the responses of one field and print how many solutions they have."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--field", help="field.csv; made up without")
    given = options.parse_args().field
    field = read_field(given) if given else made_up()
    low, high = field.frequencies[[0, -1]]
    frequency = np.geomspace(low, high, FREQUENCIES)
    own = np.geomspace(1.1 * low, 0.9 * high, HOSTS)
    levels = np.geomspace(0.1, 10.0, LEVELS)
    print(f"{HOSTS * LEVELS} responses ({HOSTS} hosts, {LEVELS} levels) at {FREQUENCIES} "
          f"frequencies of a field of {len(field.gamma)} points")  # fmt: skip
    single = [Structure.single(1.0, f, 0.01, force=1.0) for f in own]
    print("one damper", counted(respond(host, field, frequency, levels) for host in single))
    double, both = [places(f) for f in own], [field, field]
    respond_together(double[0], both, frequency[:1], levels[:1])  # compiles
    found = (respond_together(host, both, frequency, levels)[0] for host in double)
    print("two dampers on two modes", counted(found))


def places(f: float) -> list[Structure]:
    """A structure with a mode at f [Hz] and one half an octave above, at two dampers."""
    omega, shapes = 2 * np.pi * np.array([f, np.sqrt(2) * f]), ([1.0, 0.8], [0.6, -0.9])
    drive = np.array([1.0, 0.7])
    return [
        Structure(omega, np.array([0.01, 0.01]), np.array(shape), drive, drive, force=1.0)
        for shape in shapes
    ]


def counted(responses: Iterable[Responses]) -> str:
    """Cost of responses as they are computed, and their solutions, in words."""
    began = time.process_time()
    solutions, most, beyond = 0, 0, 0
    for found in responses:
        solutions += int(found.count.sum())
        most = max(most, int(found.count.max()))
        beyond += int(found.beyond.sum())
    return (
        f"{time.process_time() - began:.2f} s of CPU; {solutions} solutions, at most {most} at a "
        f"point, {beyond} points beyond the field"
    )


if __name__ == "__main__":
    main()
