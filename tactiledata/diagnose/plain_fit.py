"""The plain simulation, without any effect, fitted to trajectories."""

from __future__ import annotations

from tactiledata.diagnose.joint_fit import JointFit, joint_fit
from tactiledata.diagnose.joint_model import joint_model
from tactiledata.diagnose.whitened_cases import WhitenedCases
from tactiledata.gel.material import GelMaterial


def plain_fit(white: WhitenedCases, material: GelMaterial) -> JointFit:
    """E, nu, mu, offsets of trajectories and errors of the simulation, from a material to begin with."""
    numerical = white.numerical(material)
    model = joint_model(material, [], len(white.starts), numerical.shape[2], box=white.cases.box)
    return joint_fit(white, numerical, model)
