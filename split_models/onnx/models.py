"""SPLIT by onnxruntime, from a folder of exported networks; PyTorch is not needed."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from split_models.networks.network_inputs import require_displacements, require_pictures
from tactiledata.contract.extras import need_packages
from tactiledata.contract.schema import parse_document
from tactiledata.errors import CheckpointError, MissingFile

MODELS = "models.json"
FORMAT = "tactiledata-onnx/1"
CHUNK = 64
"""Frames that go through a network together."""


class OnnxModels:
    """The networks in a folder that `tactiledata export` wrote.

    Parameters
    ----------
    folder : Path
    document : dict, optional
        Content of ``models.json``; it is read unless given.
    threads : int
        Threads of each network; 0 leaves the number to onnxruntime.

    Raises
    ------
    MissingFile
        The folder has no ``models.json``.
    CheckpointError
        The folder has another format.
    UsageError
        The package onnxruntime is not installed.
    """

    def __init__(self, folder: Path, document: Mapping[str, Any] | None = None, threads: int = 0) -> None:
        need_packages("an ONNX file", "onnxruntime")
        self.folder, self.threads = folder, threads
        self.document = _document(folder) if document is None else dict(document)
        self.size: tuple[int, int] = tuple(self.document["image_size"])
        self.vertices = int(self.document["vertices"])
        self._sessions: dict[str, Any] = {}

    def __reduce__(self) -> tuple[Any, ...]:
        # sessions cannot be pickled; another process opens its own
        return OnnxModels, (self.folder, self.document, self.threads)

    def run(self, name: str, values: NDArray[Any]) -> NDArray[np.float32]:
        """Output of a network, float32, for values (n, ...), computed `CHUNK` at a time."""
        session = self._session(name)
        source = self.document["files"][name]["input"]
        pieces = [
            session.run(None, {source: values[start : start + CHUNK]})[0] for start in range(0, len(values), CHUNK)
        ]
        output: NDArray[np.float32] = np.concatenate(pieces)
        return output

    def picture_latents(self, pictures: NDArray[np.uint8]) -> NDArray[np.float32]:
        """Latent vectors (n, d) of pictures (n, h, w, 3), uint8.

        Raises
        ------
        UsageError
            The pictures have another size than the network's.
        """
        require_pictures(self.size, pictures)
        return self.run("image_encoder", pictures)

    def mesh_latents(self, displacements: NDArray[np.float32]) -> NDArray[np.float32]:
        """Latent vectors (n, d) of displacements (n, v, 3), m.

        Raises
        ------
        UsageError
            The number of vertices is not the network's, or displacements are NaN.
        """
        require_displacements(self.vertices, displacements)
        return self.run("mesh_encoder", np.asarray(displacements, np.float32))

    def decoded_pictures(self, latent: NDArray[np.float32]) -> NDArray[np.uint8]:
        """Pictures (n, h, w, 3), uint8, of latent vectors (n, d)."""
        return np.rint(self.run("image_decoder", latent) * 255.0).clip(0, 255).astype(np.uint8)

    def _session(self, name: str) -> Any:
        """Session of onnxruntime for a network, opened at its first use."""
        if name not in self._sessions:
            import onnxruntime

            path = self.folder / f"{name}.onnx"
            if not path.is_file():
                raise MissingFile(f"{path} does not exist", "an exported network", "Export again.")
            options = onnxruntime.SessionOptions()
            options.intra_op_num_threads = self.threads
            self._sessions[name] = onnxruntime.InferenceSession(str(path), options, providers=["CPUExecutionProvider"])
        return self._sessions[name]


@dataclass(frozen=True)
class OnnxMeshToImage:
    """SPLIT from meshes to pictures, by exported networks."""

    models: OnnxModels
    name: str = "split_onnx"

    def predict(self, displacements: NDArray[np.float32], background: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """Pictures (n, h, w, 3), uint8, of displacements (n, v, 3), m, on a background (h, w, 3)."""
        deformation = self.models.run("mesh_to_image", self.models.mesh_latents(displacements))
        return self.models.decoded_pictures(deformation + self.models.picture_latents(background[None]))

    def steps(self, background: NDArray[np.uint8]) -> list[tuple[str, Callable[[Any], Any]]]:
        """The steps of `predict` as named functions; the background is encoded once for all frames."""
        base = self.models.picture_latents(background[None])
        return [
            ("mesh encoder", self.models.mesh_latents),
            ("projection", lambda latent: self.models.run("mesh_to_image", latent) + base),
            ("decoder", self.models.decoded_pictures),
        ]


@dataclass(frozen=True)
class OnnxImageToMesh:
    """SPLIT from pictures to meshes, by exported networks."""

    models: OnnxModels
    name: str = "split_onnx"

    def predict(self, pictures: NDArray[np.uint8], background: NDArray[np.uint8]) -> NDArray[np.float32]:
        """Displacements (n, v, 3), m, of pictures (n, h, w, 3) of a sensor with a background (h, w, 3)."""
        deformation = self.models.picture_latents(pictures) - self.models.picture_latents(background[None])
        return self.models.run("mesh_decoder", self.models.run("image_to_mesh", deformation))


def _document(folder: Path) -> dict[str, Any]:
    """The document ``models.json`` of a folder; another format is refused."""
    path = folder / MODELS
    if not path.is_file():
        raise MissingFile(f"{path} does not exist", "a folder of exported networks", "`tactiledata export RECIPE`.")
    document: dict[str, Any] = parse_document(path.read_text(encoding="utf-8"), str(path))
    if document.get("format") != FORMAT:
        raise CheckpointError(f"{path} has format {document.get('format')!r}", FORMAT, "Export again.")
    return document
