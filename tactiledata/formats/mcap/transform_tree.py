"""The pose between two frames out of a tree of transforms: read where the tree has it, else composed along its edges.

A tree comes in pieces: fixed edges once on `/tf_static`, moving ones on `/tf`, often several to a message and not all
in one. The last transform of each edge is kept; whenever a moving edge between the two frames comes, the pose is
composed of the last ones. Sources: REP 105 and tf2's documentation; the code is our own.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from tactiledata.contract.records import Finding
from tactiledata.formats.mcap.collect import SignalBuffer
from tactiledata.formats.mcap.decode import FAULTS, Decoder
from tactiledata.formats.mcap.message_fields import frame_of, stamp_of, steps_of, value_at
from tactiledata.formats.mcap.undecoded import reason_of

Pose = tuple[float, ...]
"""x y z in metres and a quaternion x y z w: parent_from_child."""
Taker = Callable[[bytes, int, int, int, int], None]

IDENTITY: Pose = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)
PATHS = tuple(
    steps_of(path)
    for path in (*(f"transform.translation.{a}" for a in "xyz"), *(f"transform.rotation.{a}" for a in "xyzw"))
)
MAX_SHOWN = 12


class TransformTree:
    """Poses frame_from_child for a signal, as the messages of its topics come.

    Parameters
    ----------
    frame, child : str
        Between which two frames; slashes at their ends do not count.
    sink : SignalBuffer
    """

    def __init__(self, frame: str, child: str, sink: SignalBuffer) -> None:
        self._frame, self._child, self._sink = frame.strip("/"), child.strip("/"), sink
        self._name = frame
        self._edges: dict[str, tuple[str, Pose]] = {}

    def taker(self, decoder: Decoder, is_static: bool) -> Taker:
        """What takes the messages of one topic; fixed edges alone make no sample."""

        def take(buffer: bytes, start: int, stop: int, log_ns: int, publish_ns: int) -> None:
            try:
                transforms = list(value_at(decoder.decode(buffer[start:stop]), ("transforms",)))
                stamps = self._note(transforms)
            except FAULTS as error:
                self._sink.faults.add(log_ns, reason_of(error))
                return
            if is_static:
                return
            way = self._way()
            moved = [stamps[child] for child in way if child in stamps] if way else []
            if way and moved:
                known = [stamp for stamp in moved if stamp is not None]
                pose = self._pose(way)
                self._sink.add(pose, log_ns, publish_ns, max(known) if known else None, self._name)

        return take

    def findings(self) -> list[Finding]:
        """Findings that two frames were never joined, with the frames that there are."""
        if self._way():
            return []
        edges = sorted(f"{parent} -> {child}" for child, (parent, _) in self._edges.items())
        listed = ", ".join(edges[:MAX_SHOWN]) + (", …" if edges[MAX_SHOWN:] else "")
        text = (
            f"the transforms of {self._sink.topic} never join {self._frame!r} and {self._child!r}: {listed or 'none'}"
        )
        return [Finding("frames-not-joined", "warning", text, self._sink.name)]

    def _note(self, transforms: list[Any]) -> dict[str, int | None]:
        """Keep the transforms; returns their stamps by child frame."""
        stamps: dict[str, int | None] = {}
        for transform in transforms:
            child = str(value_at(transform, ("child_frame_id",))).strip("/")
            pose = tuple(float(value_at(transform, path)) for path in PATHS)
            self._edges[child] = (frame_of(transform).strip("/"), pose)
            stamps[child] = stamp_of(transform)
        return stamps

    def _way(self) -> dict[str, bool]:
        """Child frames of the edges between the two frames, and whether each is met going up from the moving frame."""
        above_frame, above_child = self._above(self._frame), self._above(self._child)
        if above_frame[-1] != above_child[-1]:
            return {}
        common = next(name for name in above_child if name in above_frame)
        up = above_child[: above_child.index(common)]
        down = above_frame[: above_frame.index(common)]
        return {**dict.fromkeys(up, True), **dict.fromkeys(down, False)}

    def _above(self, name: str) -> list[str]:
        """A frame and all above it; a ring ends where it closes."""
        names = [name]
        while names[-1] in self._edges and self._edges[names[-1]][0] not in names:
            names.append(self._edges[names[-1]][0])
        return names

    def _pose(self, way: dict[str, bool]) -> Pose:
        if len(way) == 1 and all(way.values()):
            return self._edges[self._child][1]
        from_child, from_frame = IDENTITY, IDENTITY
        for child, is_up in way.items():
            pose = self._edges[child][1]
            if is_up:
                from_child = composed(pose, from_child)
            else:
                from_frame = composed(pose, from_frame)
        return composed(inverted(from_frame), from_child)


def composed(a_from_b: Pose, b_from_c: Pose) -> Pose:
    """The pose a_from_c."""
    x, y, z = turned(a_from_b[3:], b_from_c[:3])
    return (a_from_b[0] + x, a_from_b[1] + y, a_from_b[2] + z, *product(a_from_b[3:], b_from_c[3:]))


def inverted(a_from_b: Pose) -> Pose:
    """The pose b_from_a, for a quaternion of length 1."""
    x, y, z, w = a_from_b[3:]
    back = (-x, -y, -z, w)
    return (*(-value for value in turned(back, a_from_b[:3])), *back)


def product(p: Pose, q: Pose) -> Pose:
    """The quaternion that turns by q, then by p; x y z w."""
    px, py, pz, pw = p
    qx, qy, qz, qw = q
    return (
        pw * qx + px * qw + py * qz - pz * qy,
        pw * qy - px * qz + py * qw + pz * qx,
        pw * qz + px * qy - py * qx + pz * qw,
        pw * qw - px * qx - py * qy - pz * qz,
    )


def turned(q: Pose, vector: Pose) -> Pose:
    """A vector turned by a quaternion of length 1."""
    return product(product(q, (*vector, 0.0)), (-q[0], -q[1], -q[2], q[3]))[:3]
