"""Stiffness along the gel: a half-space where the contact is small, a layer where it is wide."""

import numpy as np
import pytest

from tactiledata.effects.touch.shear_stiffness import shear_stiffness


def test_stiffness_has_both_limits():
    """A small contact has the stiffness of a punch on a half-space, a wide one that of a layer in simple shear."""
    small, wide, thickness, ratio = np.array([1e-8]), np.array([1e-2]), 4e-3, 0.48
    modulus = 0.5 / (1 + ratio)
    assert shear_stiffness(small, ratio, thickness)[0] == pytest.approx(
        8 * modulus * np.sqrt(small[0] / np.pi) / (2 - ratio), rel=0.05
    )
    assert shear_stiffness(wide, ratio, thickness)[0] == pytest.approx(modulus * wide[0] / thickness, rel=0.15)
