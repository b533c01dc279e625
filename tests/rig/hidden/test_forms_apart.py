"""Which formulas of the rig the catalogue has as well: all others that are compared differ.

A diagnosis that names what the rig hides is no proof where both have the same formula. The catalogue's formula is
fitted to what the rig's effect changes, on the rig's own contact, with E and mu free (`compared_forms`).
"""

import numpy as np
import pytest
from compared_forms import in_contact, in_readings

from tactiledata.effects.simulate.setting import EffectSetting
from tactiledata.prove.cases.truth import TITLES

ALIKE = 0.05
"""Share of a change, root mean square, that the nearest setting leaves at most where two formulas coincide."""
COINCIDE = {
    "stem_bending": "the tip of a clamped beam",
    "cross_talk": "a matrix, and squares of forces",
    "frame_rotation": "a rotation",
    "indenter_mount": "a rigid displacement",
    "pad_edge": "half of the support is lost within one radius of a border",
    "warm_up": "one time constant stands for two",
    "relaxation": "over a touch, one exponential stands for a power of the time",
}
"""Effects of the rig for which the catalogue has nearly the same function, and which: the first four are exact."""
OF_READINGS = ("cross_talk", "frame_rotation", "lag", "clock_skew", "ft_drift", "inertia")
"""Effects of what the force sensor reads; the others act on the contact."""
NOT_COMPARED = {
    **dict.fromkeys(("stiffening", "thickness", "dome", "skin"), "the gel engine plays them: they have no formula"),
    **dict.fromkeys(("dead_band", "saturation"), "readings show them by themselves"),
    **dict.fromkeys(("tool_weight", "cable_drag"), "the zero of each of these touches takes them"),
    "wear": "it needs a history of touches",
}
"""Effects of the rig that are not compared here, and why."""
LONG = ("delamination", "ageing_friction", "shear_strength", "relaxation")
"""Effects with several shapes, whose fits take longest."""


def cases():
    """Names of the compared effects; long fits belong to the night."""
    for name in TITLES:
        if name not in NOT_COMPARED:
            yield pytest.param(name, marks=pytest.mark.nightly if name in LONG else pytest.mark.slow)


@pytest.mark.parametrize("name", list(cases()))
def test_formulas_that_coincide_are_known(name, tmp_path):
    """A fit leaves less than a twentieth of the change where a formula is listed as shared, and more elsewhere."""
    entry = {"effect": name, "strength": "medium"}
    if name in OF_READINGS:
        compared = in_readings(entry, tmp_path)
    else:
        # each indenter is mounted in a way of its own
        compared = in_contact(entry, "ball" if name == "indenter_mount" else None)
    # the change is there, well above what rounding does
    assert np.abs(compared.change).max() > 1e-3
    assert (compared.left(TITLES[name]) < ALIKE) == (name in COINCIDE)


@pytest.mark.slow
@pytest.mark.parametrize("setting", [
    EffectSetting("rate_friction", {"beta": 0.12}),
    EffectSetting("arm_compliance", {"translation": 1e-5, "rotation": 3e-4, "lean_x": 4e-6, "lean_y": -3e-6}),
])  # fmt: skip
def test_a_formula_coincides_with_itself(setting):
    """What the catalogue's own formula changes is found again, E and mu with it, to less than a twentieth."""
    compared = in_contact({"effect": "rate_friction", "strength": "medium"}, "ball")
    compared.change[:] = compared.of_catalogue(setting, 0.03, -0.05)
    assert compared.left(setting.effect) < ALIKE
