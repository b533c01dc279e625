"""Latent arithmetic and the methods that are made of it."""

import copy

import numpy as np
import pytest
import torch
from small_models import grid_topology, image_vae, mesh_vae, pictures, presses

from split_models.learning.contact_region import contact_region
from split_models.networks.end_to_end import EndToEnd
from split_models.networks.latent import (
    AtRest,
    DirectMeshToImage,
    LatentImageToMesh,
    LatentMeshToImage,
    NoContact,
    SplitOnBackground,
    add,
    decode_pictures,
    encode_displacements,
    encode_pictures,
    subtract,
)
from split_models.networks.projection import Projection
from tactiledata.errors import CheckpointError, UsageError


@pytest.fixture(scope="module")
def networks():
    torch.manual_seed(0)
    return mesh_vae(), image_vae(), Projection(8, 16, (16, 16)), Projection(16, 8, (16, 8))


def test_adding_undoes_subtracting(networks):
    """Encoded, the background off and on again, decoded: what the VAE makes of the picture."""
    vae = networks[1]
    shown, background = pictures(3), pictures(1, seed=9)
    latent, base = encode_pictures(vae, shown), encode_pictures(vae, background)
    assert torch.allclose(add(subtract(latent, base), base), latent, atol=1e-6)
    assert not torch.equal(encode_pictures(vae, shown, "sample"), latent)


def test_the_background_takes_part_with_arithmetic_only(networks):
    """SPLIT's picture changes with the background, NOSPLIT's does not; likewise the mesh of a picture."""
    mesh, image, forth, back = networks
    dents = presses(grid_topology(), 3)
    one, other = pictures(2, seed=5)
    for is_split in (True, False):
        method = LatentMeshToImage("m", mesh, image, forth, is_split)
        assert method.predict(dents, one).shape == (3, 40, 30, 3)
        assert np.array_equal(method.predict(dents, one), method.predict(dents, other)) is not is_split
        reverse = LatentImageToMesh("r", image, mesh, back, is_split)
        found = reverse.predict(pictures(3), one)
        assert found.shape == dents.shape
        assert np.array_equal(found, reverse.predict(pictures(3), other)) is not is_split


def test_split_is_the_sum_in_latent_space(networks):
    """Its picture is the decoded sum of projection and background."""
    mesh, image, forth, _ = networks
    dents, background = presses(grid_topology(), 2), pictures(1)[0]
    with torch.no_grad():
        deformation = forth.eval()(encode_displacements(mesh, dents))
    expected = decode_pictures(image, deformation + encode_pictures(image, background[None]))
    assert np.array_equal(LatentMeshToImage("m", mesh, image, forth).predict(dents, background), expected)


def test_what_does_not_fit_is_refused(networks):
    """Another topology, another latent size, another picture size, NaN: before anything is computed."""
    mesh, image, forth, back = networks
    dents = presses(grid_topology(), 2)
    method = LatentMeshToImage("m", mesh, image, forth)
    with pytest.raises(UsageError, match=r"\(2, 100, 3\); expected \(n, 204, 3\): the mesh topology"):
        method.predict(dents[:, :100], pictures(1)[0])
    with pytest.raises(UsageError, match=r"\(n, 40, 30, 3\), uint8"):
        method.predict(dents, pictures(1, size=(80, 60))[0])
    with pytest.raises(UsageError, match="with NaN"):
        method.predict(np.full_like(dents, np.nan), pictures(1)[0])
    with pytest.raises(CheckpointError, match="a projection from 16 to 8 latent dimensions; expected from 8 to 16"):
        LatentMeshToImage("m", mesh, image, back)
    with pytest.raises(CheckpointError, match="from 16 to 8"):
        LatentImageToMesh("m", image, mesh, forth)


def test_on_the_background_only_the_change_is_decoded(networks):
    """Without a deformation it is the background to the last pixel; with one, SPLIT's change is added to it."""
    mesh, image, forth, _ = networks
    dents, background = presses(grid_topology(), 2), pictures(1)[0]
    method = LatentMeshToImage("m", mesh, image, forth)
    base = decode_pictures(image, encode_pictures(image, background[None])).astype(int)
    expected = np.clip(background + method.predict(dents, background).astype(int) - base, 0, 255)
    assert np.array_equal(SplitOnBackground("s", method).predict(dents, background), expected)
    still = copy.deepcopy(forth)
    for values in still.parameters():
        torch.nn.init.zeros_(values)
    untouched = SplitOnBackground("s", LatentMeshToImage("m", mesh, image, still)).predict(dents, background)
    assert all(np.array_equal(one, background) for one in untouched)


def test_the_plain_ones_do_nothing(networks):
    """No contact gives the background, at rest gives no displacement, end to end ignores the background."""
    background = pictures(1)[0]
    dents = presses(grid_topology(), 2)
    assert all(np.array_equal(one, background) for one in NoContact().predict(dents, background))
    assert not AtRest(204).predict(pictures(3), background).any()
    network = EndToEnd(networks[0].hierarchy, {"filters": (8, 8, 8, 16), "order": 3}, image_vae().settings)
    method = DirectMeshToImage("end_to_end", network)
    assert np.array_equal(method.predict(dents, background), method.predict(dents, background // 2))


def test_the_contact_region_is_where_the_spot_is():
    """A planted spot is found, noise is not."""
    rng = np.random.default_rng(0)
    background = np.full((80, 60, 3), 100, np.uint8)
    noisy = (background[None] + rng.normal(0, 2.0, (1, 80, 60, 3))).round().astype(np.uint8)
    assert not contact_region(noisy, background).any()
    touched = noisy.copy()
    touched[0, 30:50, 20:40] += 25
    mask = contact_region(touched, background)[0]
    assert mask[32:48, 22:38].all()
    assert not mask[:25].any()
    assert not mask[55:].any()
