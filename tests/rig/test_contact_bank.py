"""Contacts from a bank are those of the layer solver, between its solutions too."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from hidden_worlds import touch, world

from tactiledata.errors import UsageError
from tactiledata.rig.bank import bank as contact_bank
from tactiledata.rig.bank.bank import ContactBank
from tactiledata.rig.contact.by_layer import touch_layer
from tactiledata.rig.contact.contact import CONTACT_RATE, TouchSetup, contact_times
from tactiledata.rig.contact.footprint import GelGrid, make_footprint
from tactiledata.rig.layer.grid import LayerGrid
from tactiledata.rig.layer.solver import Layer
from tactiledata.rig.motion import motion
from tactiledata.rig.play import RigSetup
from tactiledata.rig.scenario.scenario import Gel

pytestmark = pytest.mark.slow

PITCH = 8e-4
STEPS = (
    {"press": {"depth": 0.0007, "step": 0.00035, "settle": 0.05}},
    {"shear": {"by": [0.0004, 0.0], "step": 0.0002, "settle": 0.05}},
)
SCENARIO = world(trajectories=[touch(steps=STEPS, tilt=[0.04, 0.0], force_limit=40.0)])
GEL = Gel()
INDENTERS = RigSetup(SCENARIO).indenters


@pytest.fixture(scope="module")
def bank(tmp_path_factory):
    return ContactBank(tmp_path_factory.mktemp("bank"), PITCH, INDENTERS)


def setup_of(offset=(0.0, 0.0, 0.0), thickness=GEL.thickness, radius=None, **material):
    (one,) = SCENARIO.trajectories
    rotation = motion.gel_from_indenter_rotation(one)
    indenter = INDENTERS[one.indenter] if radius is None else replace(INDENTERS[one.indenter], radius=radius)
    footprint = make_footprint(indenter, rotation, one.position, GelGrid.of(GEL))
    plan = partial(motion.plan, one)
    real = replace(SCENARIO.material, **material)
    return TouchSetup(one, indenter, rotation, footprint, np.array(offset), thickness, real, plan)


def solved(setup, deviation=None):
    layer = Layer(LayerGrid.of(GEL.outline, PITCH), setup.thickness, setup.material)
    return touch_layer(setup, layer, setup.plan(lambda _: 2e-3), deviation).wrench


def before_retreat(wrench):
    """Rows in which the solver's own steps are short: out of the gel they are 0.2 mm long, splines between them."""
    (start,) = (start for start, _, name in bank_path().phases if name == "retreat")
    return wrench[: int(start * CONTACT_RATE)]


def bank_path():
    return setup_of().plan(lambda _: 2e-3)


def off(found, expected):
    """Largest differences of forces and torques, over the peak force and it times a millimetre."""
    found, expected = before_retreat(found), before_retreat(expected)
    peak = np.abs(expected[:, :3]).max()
    force, torque = (np.abs(found - expected)[:, part].max() for part in (slice(0, 3), slice(3, 6)))
    return force / peak, torque / (1e-3 * peak)


@pytest.mark.parametrize("deeper", [4.5e-5, -1.3e-4])
def test_an_offset_between_the_solutions_is_as_solved(bank, deeper):
    """Between the solved offsets, the bank's force is that of the solver within 0.5 %, its torque within 1 %."""
    setup = setup_of((0.0, 0.0, deeper), youngs_modulus=0.7e6)
    force, torque = off(bank.contact(GEL, setup).wrench, solved(setup))
    assert force < 0.005
    assert torque < 0.01


def test_a_contact_beside_is_the_same_one_moved(bank):
    """A moved contact is the same as far as this coarse grid of the solver does not see where the contact lies."""
    setup = setup_of((6e-5, -4e-5, 0.0))
    force, torque = off(bank.contact(GEL, setup).wrench, solved(setup))
    assert force < 0.02
    assert torque < 0.05


def test_another_thickness_and_radius_are_nearly_as_solved(bank):
    """With another thickness or radius, the bank's force is that of the solver within 1 %."""
    for setup in (setup_of(thickness=0.95 * GEL.thickness), setup_of(radius=0.98 * INDENTERS["ball"].sizes["radius"])):
        force, _ = off(bank.contact(GEL, setup).wrench, solved(setup))
        assert force < 0.01


def test_an_indenter_that_yields_along_the_gel_is_nearly_as_solved(bank):
    """Bent back by what a stem of 18 N/mm gives: the shear that is lost is told within a tenth."""
    setup = setup_of()
    plain = bank.contact(GEL, setup)
    deviation = np.zeros((len(contact_times(plain.path)), 3))
    deviation[:, :2] = 55e-6 * plain.wrench[:, :2]
    found, expected = bank.contact(GEL, setup, None, deviation).wrench, solved(setup, deviation)
    lost = np.abs(before_retreat(plain.wrench - expected))[:, 0].max()
    assert lost > 0.2
    assert np.abs(before_retreat(found - expected))[:, 0].max() < lost / 10


def test_what_yields_next_to_nothing_along_the_gel_slides_as_before(bank):
    """Flanks push a sliding indenter beyond Coulomb's limit: no yielding takes that away."""
    setup = setup_of(friction=0.3)
    plain = bank.contact(GEL, setup)
    beyond = np.linalg.norm(plain.wrench[:, :2], axis=1) - 0.3 * plain.wrench[:, 2]
    assert beyond.max() > 0.01
    deviation = np.zeros((len(contact_times(plain.path)), 3))
    deviation[:, :2] = 1e-12 * plain.wrench[:, :2]
    np.testing.assert_allclose(bank.contact(GEL, setup, None, deviation).wrench, plain.wrench, atol=1e-6)


def test_what_was_solved_is_read_again_and_nothing_else_is(bank, monkeypatch):
    """Kept solutions are read without the solver, which another friction needs; a banked contact has no picture."""
    setup = setup_of((0.0, 0.0, 4.5e-5))
    first = bank.contact(GEL, setup).wrench
    monkeypatch.setattr(contact_bank, "touch_layer", None)
    again = ContactBank(bank.folder, PITCH, INDENTERS).contact(GEL, setup)
    assert np.abs(again.wrench - first).max() < 1e-5 * np.abs(first).max()
    assert not again.wrench[0].any()
    with pytest.raises(UsageError, match="a picture"):
        again.surface(0.1)
    with pytest.raises(TypeError):
        bank.contact(GEL, setup_of(friction=0.5))


def test_what_lies_beyond_is_refused(bank):
    """An offset or a thickness outside the solved ones is refused."""
    with pytest.raises(UsageError, match="an offset of 300"):
        bank.contact(GEL, setup_of((0.0, 0.0, 3e-4)))
    with pytest.raises(UsageError, match=r"a thickness of 0\.5"):
        bank.contact(GEL, setup_of(thickness=0.5 * GEL.thickness))
