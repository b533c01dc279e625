"""The options of a replay."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

from tactiledata.contract.provenance import digest_of
from tactiledata.effects.simulate.setting import EffectSetting, in_order
from tactiledata.gel.contact.recorder import Keep
from tactiledata.gel.elasticity.material import GelMaterial
from tactiledata.gel.engines.fem import Fidelity
from tactiledata.gel.mesh.structured_pad import Resolution, pad_mesh
from tactiledata.replay.plan import GAP_LIMIT_NS, MakePad


@dataclass(frozen=True)
class ReplayOptions:
    """All that decides the rows of a replay, apart from the store.

    Parameters
    ----------
    material : GelMaterial
        Young's modulus, Poisson's ratio and friction.
    resolution : "low" or "high"
        Mesh of the pads; the high one is interpolated from a solution on the low one.
    fidelity : "finite-strain" or "linear"
        Strain measure of the engine; linear is a preview.
    keep : "all" or "surface"
        Nodes whose displacements are stored.
    offsets : dict, uid -> m
        How much deeper the indenter of a trajectory is than recorded; 0 where not named.
    gap_limit_ns : int
        Largest gap between two pose samples, ns, across which a pose is interpolated; beyond it the pose is missing.
    indenter_folder : Path, optional
        Folder of the mesh files that recordings name by a relative path.
    name : str, optional
        Name of the mesh in the store, instead of ``low``, ``low-linear``, ``high`` or ``high-linear``.
    make_pad : callable, optional
        Makes the pad mesh of a sensor model, instead of the pads of ``resolution``.
    effects : tuple of EffectSetting
        Missing physics to simulate as well.
    """

    material: GelMaterial
    resolution: Resolution = "low"
    fidelity: Fidelity = "finite-strain"
    keep: Keep = "all"
    offsets: Mapping[str, float] = field(default_factory=dict)
    gap_limit_ns: int = GAP_LIMIT_NS
    indenter_folder: Path | None = None
    name: str | None = None
    make_pad: MakePad | None = None
    effects: tuple[EffectSetting, ...] = ()

    @property
    def mesh_name(self) -> str:
        """Name of the mesh in the store; the default one marks a linear preview and effects."""
        preview, effects = "-linear" * (self.fidelity == "linear"), "-effects" * bool(self.acting)
        return self.name or f"{self.resolution}{preview}{effects}"

    @property
    def acting(self) -> tuple[EffectSetting, ...]:
        """Effects that are not null, in the order in which they act."""
        return in_order(setting for setting in self.effects if not setting.is_null)

    @property
    def pads(self) -> MakePad:
        """Function that makes the pad mesh of a sensor model."""
        return self.make_pad or partial(pad_mesh, resolution=self.resolution)

    @property
    def is_interpolated(self) -> bool:
        """Whether the high-resolution pad is interpolated from a solution on the low-resolution one."""
        return self.make_pad is None and self.resolution == "high"

    def document(self) -> dict[str, Any]:
        """Return the options on which the rows depend, as JSON values for the manifest."""
        return {
            "engine": "fem on the low-resolution pad, interpolated" if self.is_interpolated else "fem",
            "fidelity": self.fidelity,
            "material": asdict(self.material),
            "keep": self.keep,
            "gap_limit_ns": self.gap_limit_ns,
            "offsets": len(self.offsets),
            "offsets_sha256": digest_of(dict(self.offsets)),
            **({"effects": [setting.document for setting in self.acting]} if self.acting else {}),
        }
