"""Bias, spread and coverage of displacements over textures, motions and noise (minutes).

The table of docs/results/calibration/piv-coverage.txt:
pytest -m validation -s -q tests/calibration/test_piv_coverage.py
"""

import numpy as np
import pytest
from made_pairs import MOTIONS, SHAPE, errors, grains, particles

from calibration.piv import displacement


@pytest.mark.validation
def test_sigma_covers_two_thirds_over_textures_motions_and_noise():
    """60 to 76 % of all errors of a method lie within its sigma."""
    print(f"\n{'texture':10}{'noise':>6} {'motion':14}{'method':8}{'bias u':>8}{'bias v':>8}"
          f"{'rms':>8}{'sigma':>8}{'within':>8}  [px]")  # fmt: skip
    inside: dict[str, list] = {"piv": [], "flow": []}
    for made in (particles, grains):
        for noise in (2.0, 8.0):
            for seed, (name, motion) in enumerate(MOTIONS.items()):
                pair = made(motion, 500 + seed, shape=SHAPE, noise=noise)
                for method, within in inside.items():
                    field = displacement(pair.a, pair.b, method=method)
                    wrong, sigma = errors(field, motion)
                    covered = np.abs(wrong) < sigma
                    within.append(covered.ravel())
                    bias, rms = wrong.mean(axis=1), np.sqrt((wrong**2).mean())
                    print(f"{made.__name__:10}{noise:6.0f} {name:14}{method:8}{bias[0]:8.3f}"
                          f"{bias[1]:8.3f}{rms:8.3f}{np.sqrt((sigma**2).mean()):8.3f}"
                          f"{covered.mean():8.0%}", flush=True)  # fmt: skip
    for method, within in inside.items():
        share = np.concatenate(within).mean()
        print(f"all {method}: {share:.1%}")
        assert 0.60 < share < 0.76
