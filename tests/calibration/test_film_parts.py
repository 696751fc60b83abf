"""Connected parts of a mask found by outlines, against labels of all pixels."""

import cv2
import numpy as np
import pytest

from calibration.tracking.blobs import filled, largest, outlines, pixels_within


@pytest.mark.parametrize("seed", range(5))
def test_outlines_enclose_the_parts_that_labels_give(seed):
    """As many parts; of those without holes Pick's theorem gives the number of pixels, exactly."""
    rng = np.random.default_rng(seed)
    coarse = cv2.GaussianBlur(rng.normal(size=(60, 80)), (0, 0), 2.5)
    mask = np.where(coarse > 0.1, 255, 0).astype(np.uint8)
    n, labels, stats, _ = cv2.connectedComponentsWithStats(mask)
    around = outlines(mask)
    assert len(around) == n - 1
    whole = 0
    for outline in around:
        inside = filled(outline, (0, 0, 80, 60)) > 0
        assert len(outline) == 1 or pixels_within(outline) == inside.sum()
        label = labels[outline[0, 0, 1], outline[0, 0, 0]]
        assert np.all(inside[labels == label])
        whole += stats[label, cv2.CC_STAT_AREA] == inside.sum()
    assert whole > 0


def test_the_largest_part_has_no_holes_and_nothing_next_to_it():
    mask = np.zeros((40, 40), np.uint8)
    mask[5:25, 5:25] = 255
    mask[10:14, 10:14] = 0
    mask[30:34, 30:34] = 255
    found = largest(mask)
    assert found[5:25, 5:25].all()
    assert np.count_nonzero(found) == 400
    assert largest(np.zeros((9, 9), np.uint8)) is None
