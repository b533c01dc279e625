"""Networks have the sizes that the paper states, layer by layer."""

import numpy as np
import pytest
import torch
from small_models import grid_topology, image_vae, mesh_vae, pictures, presses

from split_models.learning.checkpoint import Checkpoint, TrainedOn, load_checkpoint, save_checkpoint
from split_models.networks.end_to_end import EndToEnd
from split_models.networks.force_head import ForceHead, RawForces
from split_models.networks.image_vae import ImageVae, _enlarge, as_input, as_pictures
from split_models.networks.latent_normal import annealed, divergence
from split_models.networks.mesh_graph import build_hierarchy
from split_models.networks.mesh_vae import ChebyshevConvolution, MeshVae
from split_models.networks.perceptron import perceptron
from split_models.networks.projection import Projection
from split_models.networks.sparse_map import SparseMap
from tactiledata.errors import UsageError


def widths(network):
    return [
        (layer.in_features, layer.out_features) for layer in network.modules() if isinstance(layer, torch.nn.Linear)
    ]


def test_image_vae_of_the_paper():
    """It has [3, 3, 5, 5, 3, 3] blocks, down by 2, 2, 2, 2, 5 at 320 x 240 x 3, latent 256; the decoder mirrors it."""
    vae = ImageVae()
    assert [len(stage) for stage in vae.encoder.stages] == [3, 3, 5, 5, 3, 3]
    assert [len(stage) for stage in vae.decoder.stages] == [3, 3, 5, 5, 3, 3][::-1]
    sides = []
    values = vae.encoder.stem(torch.zeros(1, 3, 320, 240))
    for layer in vae.encoder.down:
        sides.append(tuple(values.shape[2:]))
        values = layer(values)
    assert [*sides, tuple(values.shape[2:])] == [(320, 240), (160, 120), (80, 60), (40, 30), (20, 15), (4, 3)]
    assert vae.to_mean.out_features == vae.to_log_variance.out_features == vae.latent == 256
    with torch.no_grad():
        assert vae.decode(torch.zeros(1, 256)).shape == (1, 3, 320, 240)


def test_sub_pixels_start_as_nearest_neighbours():
    """Before anything is learned, every block of pixels that one became has one value; learning tells them apart."""
    enlarge = _enlarge(6, 4, 5, "sub_pixel")
    blocks = enlarge(torch.randn(2, 6, 4, 3)).unflatten(3, (3, 5)).unflatten(2, (4, 5))
    assert blocks.shape == (2, 4, 4, 5, 3, 5)
    assert torch.allclose(blocks, blocks[:, :, :, :1, :, :1].expand_as(blocks))
    assert enlarge[0].weight.shape[0] == 4 * 25


def test_a_vae_without_bounds_is_kept_and_built_again(tmp_path):
    """SiLU and sub-pixels: features beyond 1 but normalised, pictures within; the checkpoint says how it is built."""
    torch.manual_seed(0)
    vae = image_vae(activation="silu", upsampling="sub_pixel")
    shown = as_input(torch.as_tensor(pictures(3)))
    assert vae.features(100 * shown).abs().max() > 1
    assert vae.features(100 * shown).square().mean() < 2
    assert image_vae().features(100 * shown).abs().max() <= 1
    save_checkpoint(tmp_path / "vae.pt", Checkpoint.of(vae, TrainedOn("r", "s", "i")))
    again = load_checkpoint(tmp_path / "vae.pt").network()
    assert torch.equal(again.eval()(shown)[0], vae.eval()(shown)[0])


def test_mesh_vae_of_the_paper():
    """It has four Chebyshev convolutions 16, 16, 16, 32 with K 6, pooling by 2, and two linear layers of 128."""
    topology = grid_topology(20, 20)
    vae = MeshVae(build_hierarchy(topology))
    order = [(layer.mix.in_features, layer.mix.out_features) for layer in vae.encoder.layers]
    assert order == [(6 * 3, 16), (6 * 16, 16), (6 * 16, 16), (6 * 16, 32)]
    assert [layer.mix.out_features for layer in vae.decoder.layers] == [16, 16, 16, 3]
    assert vae.hierarchy.sizes == (400, 200, 100, 50, 25)
    assert vae.to_mean.out_features == vae.to_log_variance.out_features == 128
    shapes = [tuple(one.shape) for one in vae(torch.zeros(2, 400, 3))]
    assert shapes == [(2, 400, 3), (2, 128), (2, 128)]


def test_projections_and_force_heads_of_the_paper():
    """Layers are 512, 1024, 1024, 256 both ways, and 128, 512, 512, 128 to three forces; the first two drop out."""
    assert widths(Projection(128, 256)) == [(128, 512), (512, 1024), (1024, 1024), (1024, 256)]
    assert widths(Projection(256, 128)) == [(256, 512), (512, 1024), (1024, 1024), (1024, 256), (256, 128)]
    assert widths(ForceHead(128)) == [(128, 128), (128, 512), (512, 512), (512, 128), (128, 3)]
    kinds = [type(layer).__name__ for layer in Projection(128, 256).layers]
    assert kinds == ["Linear", "ELU", "Dropout", "Linear", "ELU", "Dropout", "Linear", "ELU", "Linear"]
    dropped = [layer.p for layer in Projection(128, 256).modules() if isinstance(layer, torch.nn.Dropout)]
    assert dropped == [0.2, 0.4]
    assert [layer.p for layer in ForceHead(8).modules() if isinstance(layer, torch.nn.Dropout)] == [0.2, 0.2]


def test_chebyshev_convolution_is_the_polynomial():
    """It is what the recurrence on dense matrices gives, and its gradient is right."""
    laplacian = build_hierarchy(grid_topology(5, 4)).laplacians[0]
    layer = ChebyshevConvolution(SparseMap(laplacian), 2, 3, 4).double()
    values = torch.randn(20, 2, 2, dtype=torch.float64, requires_grad=True)
    dense = torch.as_tensor(laplacian.toarray()).double()
    terms = [torch.eye(20).double(), dense]
    terms += [2 * dense @ terms[1] - terms[0]]
    terms += [2 * dense @ terms[2] - terms[1]]
    stacked = torch.cat([torch.einsum("vw,wnc->vnc", term, values) for term in terms], dim=-1)
    assert torch.allclose(layer(values), layer.mix(stacked))
    assert torch.autograd.gradcheck(layer.laplacian, (values,))


def test_pictures_go_in_and_come_out():
    """uint8 to [-1, 1] and back is the identity."""
    shown = torch.as_tensor(pictures(3))
    assert torch.equal(as_pictures(as_input(shown)), shown)
    assert as_input(shown).abs().max() <= 1.0


def test_a_size_that_does_not_divide_is_refused():
    """The message names the factors."""
    with pytest.raises(UsageError, match=r"42 x 30 px do not divide by 10 \(2 x 5\)"):
        image_vae(size=(42, 30))
    with pytest.raises(UsageError, match="a width for every stage"):
        image_vae(blocks=(1, 1))


def test_divergence_is_that_of_normals():
    """0 for the standard normal, mu^2 / 2 for a shifted one; annealing goes linearly to its end and stays."""
    zero = torch.zeros(2, 4)
    assert divergence(zero, zero) == 0.0
    assert divergence(zero + 3.0, zero) == pytest.approx(4.5)
    assert [annealed(0.001, epoch, 50) for epoch in (0, 25, 50, 80)] == pytest.approx([0.0, 0.0005, 0.001, 0.001])
    assert annealed(0.005, 0, 0) == 0.005


def fitted(network, inputs, target, predicted, steps):
    """Error before and after so many steps on the same eight samples."""
    network.eval()
    optimiser = torch.optim.Adam(network.parameters(), lr=5e-3)
    errors = []
    for _ in range(steps):
        error = (predicted(network, inputs) - target).square().mean()
        optimiser.zero_grad()
        error.backward()
        optimiser.step()
        errors.append(error.item())
    return errors[0], errors[-1]


@pytest.mark.slow
def test_each_network_overfits_eight_samples():
    """Whatever is learned by heart is learned: nothing between input and output is cut."""
    torch.manual_seed(0)
    topology = grid_topology()
    dents = presses(topology, 8)
    moved = torch.as_tensor(dents)
    mean, spread = dents.mean(axis=0), np.maximum(dents.std(axis=0), 1e-6)
    shown = as_input(torch.as_tensor(pictures(8)))
    forces = torch.randn(8, 3)
    vae = mesh_vae(topology, mean=mean, spread=spread)
    image = image_vae()
    end = EndToEnd(
        vae.hierarchy, {"filters": (8, 8, 8, 16), "order": 3}, image_vae().settings, mean=mean, spread=spread
    )
    cases = [
        (vae, moved, vae.scaled(moved).detach(), lambda net, x: net(x)[0], 100, 0.2),
        (image, shown, shown, lambda net, x: net(x)[0], 100, 0.2),
        (end, moved, shown, lambda net, x: net(x), 100, 0.2),
        (Projection(6, 5, (32, 32, 5)), torch.randn(8, 6), torch.randn(8, 5), lambda net, x: net(x), 100, 0.05),
        (ForceHead(6, (32, 32)), torch.randn(8, 6), forces, lambda net, x: net(x), 100, 0.05),
        (RawForces(mesh_vae(topology, mean=mean, spread=spread)), moved, forces, lambda net, x: net(x), 60, 0.2),
        (RawForces(image_vae()), shown, forces, lambda net, x: net(x), 60, 0.2),
    ]
    for network, inputs, target, predicted, steps, share in cases:
        first, last = fitted(network, inputs, target, predicted, steps)
        assert last < share * first, (type(network).__name__, first, last)


def test_forces_come_out_in_newtons():
    """Scaled output times spread plus mean."""
    head = ForceHead(4, (8,), mean=(1.0, 2.0, 3.0), spread=(0.5, 0.5, 2.0)).eval()
    latent = torch.randn(5, 4)
    expected = head(latent) * torch.tensor([0.5, 0.5, 2.0]) + torch.tensor([1.0, 2.0, 3.0])
    assert torch.allclose(head.forces(latent), expected)


def test_the_output_layer_is_added_only_where_it_is_needed():
    """A last layer as wide as the output is the output."""
    assert widths(perceptron(2, (4, 3), 3, ())) == [(2, 4), (4, 3)]
    assert widths(perceptron(2, (4, 3), 5, ())) == [(2, 4), (4, 3), (3, 5)]
