"""Every equation holds in any system of units: no number in it hides a dimension."""

import dataclasses

import numpy as np
import pytest
from example_effect import EVERY_EFFECT

from tactiledata.effects import EFFECTS
from tactiledata.effects.closed_form.ball_on_layer import BallOnLayer
from tactiledata.effects.parameter import DIMENSIONS
from tactiledata.effects.simulate.setting import EffectSetting
from tactiledata.effects.simulate.simulator import with_effects
from tactiledata.gel.elasticity.material import GelMaterial
from tactiledata.indenters.sphere import Sphere

LENGTH, FORCE, TIME = 1.1, 0.9, 1.2


class LinearVariants(BallOnLayer):
    """Variants that act in proportion: what lies between design points is then exact."""

    def difference(self, variant):
        radius, plain = self.touch.indenter.sizes["radius"], self.respond(*nothing(self.touch))
        amount = variant.c20 + variant.c30 + variant.thickness + variant.indenter_scale - 2.0
        return plain.wrench * (amount + variant.dome * radius**2 + variant.skin / radius)


def nothing(touch):
    n = len(touch)
    return np.zeros(n), np.zeros((n, 2)), np.ones(n)


def in_other_units(touch):
    poses = touch.poses.copy()
    poses[:, :3, 3] *= LENGTH
    material, geometry = touch.material, touch.geometry
    return dataclasses.replace(
        touch,
        seconds=touch.seconds * TIME,
        poses=poses,
        indenter=Sphere(touch.indenter.radius * LENGTH),
        material=GelMaterial(material.youngs_modulus * FORCE / LENGTH**2, material.poisson_ratio, material.friction),
        geometry=dataclasses.replace(
            geometry,
            outline=(geometry.outline[0] * LENGTH, geometry.outline[1] * LENGTH),
            thickness=geometry.thickness * LENGTH,
            edge_thickness=geometry.edge_thickness * LENGTH,
        ),
        gravity=touch.gravity * LENGTH / TIME**2,
        powered=touch.powered * TIME,
        earlier_depth=touch.earlier_depth * LENGTH,
        selection=(touch.selection[0] * FORCE, touch.selection[1] * FORCE),
    )


@pytest.mark.parametrize("name", EVERY_EFFECT, indirect=True)
def test_units_do_not_matter(name, touch, play, medium):
    """Touch and parameters in other units of length, force and time give the same wrench in those units."""
    values = {p.name: medium(name).get(p.name, p.default) for p in EFFECTS[name].parameters}
    factors = {
        p.name: LENGTH ** DIMENSIONS[p.unit][0] * FORCE ** DIMENSIONS[p.unit][1] * TIME ** DIMENSIONS[p.unit][2]
        for p in EFFECTS[name].parameters
    }
    if name == "quantisation":  # steps that rounding could take either way
        values |= {"step": 0.0371, "torque_step": 0.00223, "dead_band": 0.1317}
    here = play(name, base=LinearVariants, **values).wrench
    scaled = EffectSetting(name, {key: value * factors[key] for key, value in values.items()})
    there = with_effects(LinearVariants, [scaled]).play(in_other_units(touch)).wrench
    there[:, :3] /= FORCE
    there[:, 3:] /= FORCE * LENGTH
    np.testing.assert_allclose(there, here, rtol=1e-6, atol=1e-8)


BASE = {"1": (0, 0, 0), "rad": (0, 0, 0), "m": (1, 0, 0), "N": (0, 1, 0), "s": (0, 0, 1)}
DERIVED = {"Hz": "1/s", "Pa": "N/m^2", "J": "N m", "kg": "N s^2/m"}  # N = kg m / s^2


def exponents(unit):
    """Exponents of length, force and time of a unit, read as it is written."""
    top, _, bottom = unit.partition("/")
    total = np.zeros(3, dtype=int)
    for part, sign in ((top, 1), (bottom, -1)):
        for factor in part.strip("()").split():
            name, _, power = factor.partition("^")
            one = exponents(DERIVED[name]) if name in DERIVED else np.array(BASE[name])
            total += sign * int(power or 1) * one
    return total


@pytest.mark.parametrize("unit", DIMENSIONS)
def test_dimensions_are_those_of_the_unit(unit):
    """A newton is a kg m / s^2, a joule a N m, a pascal a N / m^2."""
    assert DIMENSIONS[unit] == tuple(exponents(unit))
