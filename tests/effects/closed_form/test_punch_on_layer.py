"""The flat punch of the effects' previews against the rig's, which shares no line with it."""

import dataclasses

import numpy as np
import pytest

from tactiledata.effects.closed_form.punch_on_layer import PunchOnLayer
from tactiledata.effects.simulate.reference_touch import reference_touch
from tactiledata.effects.touch.response import GelVariant
from tactiledata.gel.elasticity.material import GelMaterial
from tactiledata.indenters.cylinder_flat import CylinderFlat
from tactiledata.rig.contact.closed_form import punch_stiffness
from tactiledata.rig.scenario.scenario import Material

MATERIAL = GelMaterial(0.9e6, 0.4999, 0.6)


@pytest.fixture
def touch():
    return dataclasses.replace(reference_touch(), indenter=CylinderFlat(0.003), material=MATERIAL)


def played(touch, variant=None):
    n = len(touch)
    punch = PunchOnLayer(touch)
    plain = punch.respond(np.zeros(n), np.zeros((n, 2)), np.ones(n))
    return plain if variant is None else plain.wrench + punch.difference(variant)


def test_stiffness_is_that_of_the_rigs_punch(touch):
    """Linear in depth, with the layer's factor, where the rubber is incompressible; nothing in free air."""
    answer = played(touch)
    pressed = answer.depth > 0
    wanted = punch_stiffness(np.array([0.003]), touch.geometry.thickness, Material(0.9e6, 0.4999))[0]
    assert answer.wrench[pressed, 2] == pytest.approx(wanted * answer.depth[pressed], rel=2e-3)
    assert not answer.wrench[~pressed].any()


def test_shear_stays_within_friction_and_slides(touch):
    """Coulomb's limit is reached in the slide of 2 mm, and never passed."""
    answer = played(touch)
    shear, normal = np.linalg.norm(answer.wrench[:, :2], axis=1), answer.wrench[:, 2]
    assert (shear <= 0.6 * normal + 1e-9).all()
    assert answer.sliding.any()


def test_variants_act_in_their_direction(touch):
    """A thinner gel and a coating are stiffer; the null changes nothing."""
    plain = played(touch).wrench[:, 2].max()
    assert played(touch, GelVariant(thickness=0.9))[:, 2].max() > plain
    assert played(touch, GelVariant(skin=3e-4))[:, 2].max() > plain
    assert not PunchOnLayer(touch).difference(GelVariant()).any()
