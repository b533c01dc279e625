"""The geometry of a sensor's gel: what its recording states wins over the sensor model."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from tactiledata.sensors import SENSORS
from tactiledata.sensors.base import GelGeometry

SHORTEST, LONGEST = 2e-3, 0.1
"""m, of a gel's long side; another size means another unit."""


def gel_geometry(facts: Mapping[str, Any]) -> GelGeometry | None:
    """The gel of a sensor; ``None`` where neither its recording nor its model tells outline and thickness.

    Parameters
    ----------
    facts : dict
        ``model`` and ``gel`` as under ``sensors:`` in schemas/log.json.
    """
    stated = dict(facts.get("gel", {}))
    model = str(facts.get("model", ""))
    known = SENSORS[model].gel if model in SENSORS else None
    if known is None:
        if "outline" not in stated or "thickness" not in stated:
            return None
        known = GelGeometry(tuple(stated["outline"]), stated["thickness"], stated["thickness"])
    thickness = stated.get("thickness", known.thickness)
    return replace(
        known,
        outline=tuple(stated.get("outline", known.outline)),
        thickness=thickness,
        edge_thickness=stated.get("edge_thickness", min(known.edge_thickness, thickness)),
    )


def implausible(geometry: GelGeometry) -> str:
    """What of a geometry cannot be meant, in words; empty where nothing."""
    short, long = geometry.outline
    if not (SHORTEST <= long <= LONGEST and SHORTEST <= short <= long):
        return f"an outline of {short:g} x {long:g} m; expected short and long side of {SHORTEST:g} to {LONGEST:g} m"
    if not 0 < geometry.edge_thickness <= geometry.thickness <= short:
        return f"a thickness of {geometry.thickness:g} m, {geometry.edge_thickness:g} m at the rim"
    return ""
