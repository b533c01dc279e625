"""Taxim, FOTS and ACROSS: nothing drawn where nothing touches, and a calibrated unit's own colours."""

import numpy as np
import pytest
from small_models import grid_topology, mesh_vae, presses

from split_models.methods.across import AcrossMethod
from split_models.methods.fots import ColourNetwork, change_by, fots_calibrated, fots_published, learned_colours
from split_models.methods.optical_method import OpticalMethod
from split_models.methods.taxim import taxim_calibrated, taxim_published, taxim_registered
from tactiledata.errors import UsageError
from tactiledata.metrics.image_similarity import l1
from tactiledata.optics.height_map import Indentation, contact_mask
from tactiledata.optics.registration import Touch
from tactiledata.optics.surface import GelSurface
from tactiledata.optics.taxim import TaximTable
from tactiledata.optics.taxim_calibration import CalibrationPress
from tactiledata.optics.view import View
from tactiledata.sensors.digit import DIGIT

pytestmark = pytest.mark.slow

TOPOLOGY = grid_topology(41, 33, 0.0006)
SURFACE = GelSurface(TOPOLOGY.places, TOPOLOGY.faces)
SHAPE = (80, 60)
BACKGROUND = np.full((*SHAPE, 3), (90, 120, 150), np.uint8)


@pytest.fixture(scope="module")
def unit():
    """A unit with colours of its own, its moved view, and twelve touches."""
    bins = 32
    theta = (np.arange(bins) / (bins - 1)) * 2 * np.pi - np.pi
    angle = np.arange(bins) / (bins - 1) * np.pi / 2
    coefficients = np.zeros((bins, bins, 3, 6))
    for channel, azimuth in enumerate((0.4, 2.4, -1.5)):
        coefficients[..., channel, 5] = 90 * np.sin(angle)[:, None] * np.cos(theta - azimuth)[None]
        coefficients[..., channel, 3] = 0.2 * coefficients[..., channel, 5]
    nominal = View.nominal(DIGIT, SHAPE)
    view = View(SHAPE, np.array([[1, 0, 3e-4], [0, 1, -4e-4], [0, 0, 1]]) @ nominal.gel_from_pixel)
    truth = OpticalMethod("truth", SURFACE, view, TaximTable(coefficients, "unit").change)
    moved = presses(TOPOLOGY, 24)
    return view, moved, truth.predict(moved, BACKGROUND)


def inside(moved, view):
    """Contact masks of meshes."""
    drawn = Indentation(SURFACE, view)
    return contact_mask(drawn.of_batch(moved))


@pytest.mark.parametrize("made", [taxim_published, fots_published])
def test_published_methods_leave_untouched_pictures_alone(made):
    """An undeformed mesh gives the background, bit for bit; a touch changes its own place only."""
    method = made(SURFACE)
    pictures = method.predict(np.concatenate([np.zeros((1, *TOPOLOGY.places.shape)), presses(TOPOLOGY, 1)]), BACKGROUND)
    np.testing.assert_array_equal(pictures[0], BACKGROUND)
    changed = np.abs(pictures[1].astype(int) - BACKGROUND).max(axis=2)
    assert changed.max() > 20
    far = Indentation(SURFACE, View.nominal(DIGIT, SHAPE)).of(presses(TOPOLOGY, 1)[0]) < 1e-6
    assert changed[far].max() <= 3


def test_a_registered_camera_changes_nothing_but_the_view():
    """Through the nominal camera the picture is the published one; through a shifted camera it is shifted."""
    moved = presses(TOPOLOGY, 1)
    published = taxim_published(SURFACE).predict(moved, BACKGROUND)
    view = View.nominal(DIGIT)
    np.testing.assert_array_equal(taxim_registered(SURFACE, view, []).predict(moved, BACKGROUND), published)
    shift = np.array([[1.0, 0.0, 12.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    shifted = taxim_registered(SURFACE, View(view.shape, view.gel_from_pixel @ shift), [])
    assert np.abs(shifted.predict(moved, BACKGROUND).astype(int) - published).max() > 5


@pytest.mark.parametrize(("made", "share"), [(taxim_calibrated, 0.25), (fots_calibrated, 0.35)])
def test_calibrated_methods_draw_touches_they_have_not_seen(unit, made, share):
    """Of what a unit's touches change inside the contact, most is predicted for touches that took no part."""
    view, moved, pictures = unit
    touches = [Touch(picture, BACKGROUND, one) for picture, one in zip(pictures[:16], moved, strict=False)]
    method = made(SURFACE, view, touches)
    mask = inside(moved[16:], view)
    whole = l1(np.stack([BACKGROUND] * 8), pictures[16:], mask).mean()
    left = l1(method.predict(moved[16:], BACKGROUND), pictures[16:], mask).mean()
    assert whole > 8
    assert left < share * whole


def test_published_colours_are_not_this_units(unit):
    """The published table knows another DIGIT: on this one it predicts far worse than a calibration."""
    view, moved, pictures = unit
    mask = inside(moved[16:], view)
    whole = l1(np.stack([BACKGROUND] * 8), pictures[16:], mask).mean()
    published = l1(taxim_published(SURFACE).predict(moved[16:], BACKGROUND), pictures[16:], mask).mean()
    assert published > 0.5 * whole


def test_pictures_of_other_sizes_show_the_same():
    """A background of twice the size gives the same picture, finer."""
    moved = presses(TOPOLOGY, 1)
    method = taxim_published(SURFACE)
    small = method.predict(moved, BACKGROUND)[0]
    large = method.predict(moved, np.repeat(np.repeat(BACKGROUND, 2, 0), 2, 1))[0]
    reduced = large.reshape(80, 2, 60, 2, 3).mean(axis=(1, 3))
    assert np.abs(reduced - small).mean() < 1.5


def test_a_fots_network_learns_what_it_is_taught():
    """Colours of a quarter of the pixels predict those of the others; flat gel stays as it is."""
    rng = np.random.default_rng(0)

    def press():
        slope = rng.uniform(-1, 1, (60, 60, 2)).astype(np.float32)
        change = 60 * np.stack([slope[..., 0], slope[..., 1], -slope[..., 0] * slope[..., 1]], axis=-1)
        return CalibrationPress(change, slope, np.ones((60, 60), bool))

    network = learned_colours([press() for _ in range(12)])
    other = press()
    left = np.abs(change_by(network, other.slopes) - other.change).mean()
    assert left < 0.1 * np.abs(other.change).mean()
    assert (change_by(network, np.zeros((4, 4, 2), np.float32)) == 0).all()
    assert (change_by(ColourNetwork(), np.zeros((4, 4, 2), np.float32)) == 0).all()


def test_across_is_taxim_on_what_the_mesh_vae_gives_back():
    """Its picture is Taxim's of the reconstructed mesh; a mesh of another topology is refused."""
    from split_models.networks.latent import decode_displacements, encode_displacements

    topology = grid_topology()
    vae = mesh_vae(topology).eval()
    taxim = taxim_published(GelSurface(topology.places, topology.faces))
    moved = presses(topology, 2)
    again = decode_displacements(vae, encode_displacements(vae, moved))
    np.testing.assert_array_equal(AcrossMethod(vae, taxim).predict(moved, BACKGROUND), taxim.predict(again, BACKGROUND))
    with pytest.raises(UsageError):
        AcrossMethod(vae, taxim).predict(presses(TOPOLOGY, 1), BACKGROUND)


def test_nothing_to_calibrate_on_is_refused():
    """No touches, and touches of nothing, are refused."""
    view = View.nominal(DIGIT, SHAPE)
    still = Touch(BACKGROUND, BACKGROUND, np.zeros(TOPOLOGY.places.shape, np.float32))
    for made in (taxim_calibrated, fots_calibrated):
        with pytest.raises(UsageError, match="no touch"):
            made(SURFACE, view, [])
        with pytest.raises(UsageError, match="slope"):
            made(SURFACE, view, [still])
