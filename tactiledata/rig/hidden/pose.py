"""Hidden deflections of the arm and the indenter under load, and backlash in the joints."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from tactiledata.arrays import RealArray
from tactiledata.rig.contact.contact import TouchSetup, contact_times
from tactiledata.rig.hidden.base import HiddenEffect, Parameters, TouchFacts
from tactiledata.rig.motion import motion, ur5e
from tactiledata.rig.motion.motion import Path

PARTS_OF_STIFFNESS = (1.0, 1.0, 1.0, 0.4, 0.4, 0.4)
"""Relative stiffness of the six joints: shoulder and elbow, and the smaller wrist joints."""


def sensor_poses(positions: RealArray, setup: TouchSetup, facts: TouchFacts) -> RealArray:
    """Return base_from_gel (n, 4, 4), metres, at positions over the gel.

    Parameters
    ----------
    positions : (n, 3), m
        Positions of the indenter: x, y of the tip, depth.
    setup : TouchSetup
        The touch as it really is.
    facts : TouchFacts
        Mounting of sensor and indenter.
    """
    tcp_from_gel = facts.scenario.robot.tcp_from_gel
    tcp = motion.base_from_tcp(positions, setup.rotation, setup.footprint.lowest, facts.mounted, tcp_from_gel)
    return tcp @ tcp_from_gel.matrix


def joint_angles(poses: RealArray, facts: TouchFacts) -> RealArray:
    """Return the joint angles (n, 6), rad, at poses base_from_gel (n, 4, 4)."""
    robot = facts.scenario.robot
    return ur5e.inverse(poses @ (robot.flange_from_tcp @ robot.tcp_from_gel).inverse().matrix)


def _moves_over_gel(poses: RealArray, joints: RealArray) -> RealArray:
    """Return the move of the indenter over the gel per joint angle (n, 3, 6), m/rad, gel axes: minus the gel's own.

    ``poses`` (n, 4, 4) are base_from_gel, ``joints`` (n, 6) the angles there, rad.
    """
    jacobian = ur5e.jacobian(joints, poses[:, :3, 3])[:, :3]
    return -np.swapaxes(poses[:, :3, :3], 1, 2) @ jacobian


@dataclass(frozen=True)
class HiddenJointCompliance(HiddenEffect):
    """The joints deflect behind their encoders: C = J K⁻¹ Jᵀ with the arm's Jacobian J at the gel.

    Parameters
    ----------
    softness : rad/(N m)
        Compliance of shoulder and elbow; wrist joints are 2.5 times as soft.
    """

    NUMBER: ClassVar[str] = "11"
    ACTS: ClassVar[str] = "pose"
    SOURCE: ClassVar[str] = "C. Dumas et al., Robotics and Computer-Integrated Manufacturing 27 (2011)"
    STRENGTHS: ClassVar[Mapping[str, Parameters]] = {
        "weak": {"softness": 1 / 80e3},
        "medium": {"softness": 1 / 32e3},
        "strong": {"softness": 1 / 13e3},
    }
    RANGES: ClassVar[Mapping[str, tuple[float, float]]] = {"softness": (0.0, 1e-3)}
    softness: float = 0.0

    def compliance(self, path: Path, setup: TouchSetup, facts: TouchFacts) -> RealArray | None:
        """Return the compliance (3, 3), m/N, gel frame, at the deepest point: the path is much smaller than the arm.

        Parameters
        ----------
        path : Path
            The commanded path.
        setup : TouchSetup
            The touch as it really is.
        facts : TouchFacts
            Mounting of sensor and indenter.
        """
        poses = sensor_poses(path.positions[[int(np.argmax(path.positions[:, 2]))]], setup, facts)
        moves = _moves_over_gel(poses, joint_angles(poses, facts))[0]
        answer: RealArray = moves @ np.diag(self.softness / np.array(PARTS_OF_STIFFNESS)) @ moves.T
        return answer


@dataclass(frozen=True)
class HiddenStemBending(HiddenEffect):
    """The indenter's stem bends like a beam clamped at its foot: by L³ / (3 E I), I = pi d⁴ / 64, across its axis.

    Parameters
    ----------
    softness : 1/m
        Reciprocal of the stem's diameter, 1 / d.
    length : m
        Length L of the stem.
    modulus : Pa
        Young's modulus E of the stem; the default is that of a printed part.
    """

    NUMBER: ClassVar[str] = "12"
    ACTS: ClassVar[str] = "pose"
    SOURCE: ClassVar[str] = "Euler-Bernoulli beam, loaded at its tip"
    STRENGTHS: ClassVar[Mapping[str, Parameters]] = {
        "weak": {"softness": 1 / 0.010},
        "medium": {"softness": 1 / 0.006},
        "strong": {"softness": 1 / 0.004},
    }
    RANGES: ClassVar[Mapping[str, tuple[float, float]]] = {
        "softness": (0.0, 400.0),
        "length": (1e-3, 0.1),
        "modulus": (1e8, 3e11),
    }
    softness: float = 0.0
    length: float = 0.030
    modulus: float = 2.5e9

    def compliance(self, path: Path, setup: TouchSetup, facts: TouchFacts) -> RealArray | None:
        """Return the compliance (3, 3), m/N, gel frame, across the stem.

        Parameters
        ----------
        path : Path
            The commanded path; without influence.
        setup : TouchSetup
            The indenter's orientation counts.
        facts : TouchFacts
            Without influence.
        """
        bending = self.length**3 / (3 * self.modulus * np.pi / 64) * self.softness**4
        axis = setup.rotation[:, 2]
        answer: RealArray = bending * (np.eye(3) - np.outer(axis, axis))
        return answer


@dataclass(frozen=True)
class HiddenJointBacklash(HiddenEffect):
    """Each joint follows its encoder with play: it rests until the encoder has moved half the play away from it.

    Parameters
    ----------
    play : rad
        Whole width of the play, the same in every joint.
    """

    NUMBER: ClassVar[str] = "outside"
    ACTS: ClassVar[str] = "pose"
    SOURCE: ClassVar[str] = "the play operator: A. Visintin, Differential Models of Hysteresis (1994)"
    STRENGTHS: ClassVar[Mapping[str, Parameters]] = {
        "weak": {"play": 5e-5},
        "medium": {"play": 1e-4},
        "strong": {"play": 3e-4},
    }
    RANGES: ClassVar[Mapping[str, tuple[float, float]]] = {"play": (0.0, 0.01)}
    play: float = 0.0

    def shift(self, path: Path, setup: TouchSetup, facts: TouchFacts) -> RealArray | None:
        """Return the deviation from the path (n, 3), m, x, y, depth; at the start every joint is in mid-play.

        Parameters
        ----------
        path : Path
            The commanded path.
        setup : TouchSetup
            The touch as it really is.
        facts : TouchFacts
            Mounting of sensor and indenter.
        """
        poses = sensor_poses(path.at(contact_times(path)), setup, facts)
        angles = joint_angles(poses, facts)
        lost = followed(angles, self.play) - angles
        moves = np.einsum("nij,nj->ni", _moves_over_gel(poses, angles), lost)
        moves[:, 2] *= -1.0  # depth grows downwards
        return moves


def followed(angles: RealArray, play: float) -> RealArray:
    """Return the angles (n, 6), rad, that follow given ones with a play, rad, and begin in the middle of it."""
    out = angles.copy()
    for moment in range(1, len(angles)):
        out[moment] = np.clip(out[moment - 1], angles[moment] - play / 2, angles[moment] + play / 2)
    return out
