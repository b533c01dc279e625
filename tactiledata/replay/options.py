"""What a user may choose of a replay."""

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
    """What shapes the rows of a replay, beside the store.

    Parameters
    ----------
    material : GelMaterial
    resolution : "low" or "high"
    fidelity : "finite-strain" or "linear"
    keep : "all" or "surface"
        Which nodes' displacements are kept.
    offsets : dict, uid -> m
        By how much the indenter of a trajectory is deeper than recorded; 0 where not named.
    gap_limit_ns : int
        A pose between samples further apart is missing.
    indenter_folder : Path, optional
        Where the meshes of indenters lie that recordings name by a path.
    name : str, optional
        Of the mesh in the store, instead of ``low``, ``low-linear``, ``high`` or ``high-linear``.
    make_pad : callable, optional
        A pad of one's own for each sensor model, instead of those of ``resolution``.
    effects : tuple of EffectSetting
        Missing physics to replay with.
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
        """The name of the mesh in the store; that of a preview says so, and that of one with effects."""
        preview, effects = "-linear" * (self.fidelity == "linear"), "-effects" * bool(self.acting)
        return self.name or f"{self.resolution}{preview}{effects}"

    @property
    def acting(self) -> tuple[EffectSetting, ...]:
        """Those of the effects that change anything, in the order in which they act."""
        return in_order(setting for setting in self.effects if not setting.is_null)

    @property
    def pads(self) -> MakePad:
        """What makes the pads."""
        return self.make_pad or partial(pad_mesh, resolution=self.resolution)

    @property
    def is_carried(self) -> bool:
        """Whether the contact is solved on the low-resolution pad, and the high one carried by it."""
        return self.make_pad is None and self.resolution == "high"

    def document(self) -> dict[str, Any]:
        """What the rows depend on, as the manifest keeps it."""
        return {
            "engine": "fem on the low-resolution pad, interpolated" if self.is_carried else "fem",
            "fidelity": self.fidelity,
            "material": asdict(self.material),
            "keep": self.keep,
            "gap_limit_ns": self.gap_limit_ns,
            "offsets": len(self.offsets),
            "offsets_sha256": digest_of(dict(self.offsets)),
            **({"effects": [setting.document for setting in self.acting]} if self.acting else {}),
        }
