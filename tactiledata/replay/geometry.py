"""Geometry of a sensor's gel: values of its recording, completed by those of the sensor model."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from tactiledata.sensors import SENSORS
from tactiledata.sensors.base import GelGeometry

SHORTEST, LONGEST = 2e-3, 0.1
"""Limits of a gel's long side, m; a size outside them means that the unit is wrong."""


def gel_geometry(facts: Mapping[str, Any]) -> GelGeometry | None:
    """Return the gel of a sensor, or ``None`` where neither recording nor model state outline and thickness.

    Parameters
    ----------
    facts : dict
        ``model`` and ``gel`` as under ``sensors:`` in schemas/log.json.
    """
    stated = dict(facts.get("gel", {}))
    model = str(facts.get("model", ""))
    nominal = SENSORS[model].gel if model in SENSORS else None
    if nominal is None:
        if "outline" not in stated or "thickness" not in stated:
            return None
        nominal = GelGeometry(tuple(stated["outline"]), stated["thickness"], stated["thickness"])
    thickness = stated.get("thickness", nominal.thickness)
    return replace(
        nominal,
        outline=tuple(stated.get("outline", nominal.outline)),
        thickness=thickness,
        edge_thickness=stated.get("edge_thickness", min(nominal.edge_thickness, thickness)),
    )


def implausible(geometry: GelGeometry) -> str:
    """Describe which values of a geometry are implausible; empty where all are plausible."""
    short, long = geometry.outline
    if not (SHORTEST <= long <= LONGEST and SHORTEST <= short <= long):
        return f"an outline of {short:g} x {long:g} m; expected short and long side of {SHORTEST:g} to {LONGEST:g} m"
    if not 0 < geometry.edge_thickness <= geometry.thickness <= short:
        return f"a thickness of {geometry.thickness:g} m, {geometry.edge_thickness:g} m at the rim"
    return ""
