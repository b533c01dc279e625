"""Latent transfer: its laws hold for any weights, trained or not."""

from pathlib import Path

import numpy as np
import pytest
import torch
from small_models import image_vae, mesh_vae, pictures

from split_models.learning.checkpoint import Checkpoint, TrainedOn, save_checkpoint
from split_models.networks.latent import decode_pictures, encode_pictures
from split_models.transfer.latent_transfer import LatentTransfer, laid_on, load_image_vae
from split_models.transfer.methods import LATENT, transfer_method, vae_transfer
from split_models.transfer.picture_size import scaled
from tactiledata.errors import CheckpointError, MissingFile, UsageError


@pytest.fixture(scope="module")
def vae():
    torch.manual_seed(0)
    return image_vae()


@pytest.fixture(scope="module")
def sensors():
    """Touches of a sensor, its background and another's, at the VAE's size."""
    source, target = pictures(2, seed=1)
    return pictures(5, seed=2), source, target


def decoded(vae, images):
    return decode_pictures(vae, encode_pictures(vae, images))


def close(one, other):
    """Equal to the rounding of a grey level."""
    assert np.abs(one.astype(int) - other).max() <= 1


def test_same_background_is_the_vae_alone(vae, sensors):
    """From a sensor to itself the arithmetic cancels: what is left is encode and decode."""
    touches, source, _ = sensors
    close(LatentTransfer("latent", vae).transfer(touches, source, source), decoded(vae, touches))


def test_background_maps_to_the_decoded_background(vae, sensors):
    """The source without contact becomes the target as the VAE draws it."""
    _, source, target = sensors
    close(LatentTransfer("latent", vae).transfer(source[None], source, target), decoded(vae, target[None]))


@pytest.mark.parametrize("laid", ["change", "ratio"])
def test_kept_background_maps_to_background_exactly(vae, sensors, laid):
    """Laid on the target's own background, no contact is that background, to the last bit, at any size."""
    _, source, target = sensors
    large = scaled(target[None], (80, 60))[0]
    method = LatentTransfer("laid", vae, laid)
    np.testing.assert_array_equal(method.transfer(source[None], source, target)[0], target)
    np.testing.assert_array_equal(method.transfer(source[None], source, large)[0], large)


def test_a_ratio_and_a_change_are_laid_as_their_names_say():
    """Half the light is half the light on any background; so many levels less are as many less."""
    untouched = np.full((1, 4, 4, 3), 80, np.uint8)
    drawn, background = np.stack([untouched[0] // 2, untouched[0]]), np.full((4, 4, 3), 120, np.uint8)
    assert laid_on(background, drawn, untouched, "ratio")[:, 0, 0, 0].tolist() == [60, 120]
    assert laid_on(background, drawn, untouched, "change")[:, 0, 0, 0].tolist() == [80, 120]
    dark = np.zeros_like(untouched)
    assert np.array_equal(laid_on(background, dark, dark, "ratio")[0], background)


@pytest.mark.parametrize("name", LATENT)
def test_sizes_of_source_and_target_may_differ(vae, sensors, name):
    """Pictures come out in the target's size, one for each touch."""
    touches, source, target = sensors
    wide = scaled(target[None], (30, 40))[0]
    assert vae_transfer(name, vae).transfer(touches, source, wide).shape == (5, 30, 40, 3)
    assert vae_transfer(name, vae).transfer(touches[:0], source, wide).shape == (0, 30, 40, 3)


def test_adain_gives_the_target_to_itself_and_knows_no_source_background(vae, sensors):
    """The target without contact has its own statistics already; another source background changes nothing."""
    touches, source, target = sensors
    adain = vae_transfer("adain", vae)
    close(adain.transfer(target[None], source, target), decoded(vae, target[None]))
    np.testing.assert_array_equal(adain.transfer(touches, source, target), adain.transfer(touches, target, target))
    assert (adain.transfer(touches, source, source) != decoded(vae, touches)).any()  # no identity: as published


def test_scaling_to_the_own_size_changes_nothing(sensors):
    """Pictures that fit are not touched; there and back the mean stays."""
    touches, _, _ = sensors
    assert scaled(touches, (40, 30)) is touches
    assert abs(float(scaled(touches, (20, 15)).mean()) - float(touches.mean())) < 1


def test_lying_pictures_are_turned_upright_and_back(sensors):
    """A quarter, not squeezed, and the other way round back: no pixel is lost."""
    touches, _, _ = sensors
    lying = scaled(touches, (30, 40))
    np.testing.assert_array_equal(np.rot90(lying, axes=(1, 2)), touches)
    np.testing.assert_array_equal(scaled(lying, (40, 30)), touches)
    assert scaled(lying, (20, 15)).shape == (5, 20, 15, 3)


def test_a_mesh_model_is_refused(tmp_path):
    """A checkpoint of another kind, with the topology it was trained on, is named as what it is."""
    save_checkpoint(tmp_path / "mesh.ckpt", Checkpoint.of(mesh_vae(), TrainedOn()))
    with pytest.raises(CheckpointError, match=r"holds a mesh_vae for one mesh topology.*image_vae"):
        load_image_vae(tmp_path / "mesh.ckpt")


def test_a_folder_in_the_place_of_a_model_names_the_file_in_it(tmp_path):
    """The folder that `train` prints is not said to be missing: the checkpoint in it is named."""
    with pytest.raises(MissingFile, match=r"is a folder; .* Name the checkpoint"):
        transfer_method("latent", tmp_path)
    (tmp_path / "best.pt").touch()
    with pytest.raises(MissingFile, match=r"is a folder; .* Name .*best\.pt\."):
        transfer_method("latent", tmp_path)


def test_a_model_for_a_method_that_takes_none_is_refused():
    """The message lists every method that takes one."""
    with pytest.raises(UsageError, match=r"latent, latent-on-background, .*latent-relit, adain"):
        transfer_method("relit", Path("best.pt"))
