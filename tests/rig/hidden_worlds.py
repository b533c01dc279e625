"""A quiet rig for hidden effects: what a touch and a log are with them and without."""

from dataclasses import dataclass

import numpy as np

from tactiledata.rig.contact.contact import contact_times
from tactiledata.rig.logs.sampling import sample
from tactiledata.rig.play import PlayedLog, RigSetup
from tactiledata.rig.record import log_groups
from tactiledata.rig.scenario.scenario import Scenario, load_scenario

QUIET = dict.fromkeys(
    (
        "pose_repeatability",
        "force_noise",
        "torque_noise",
        "force_bias",
        "force_drift",
        "force_quantum",
        "torque_quantum",
        "tcp_noise",
    ),
    0.0,
)
PRESS = {"press": {"depth": 0.0008, "step": 0.0002, "settle": 0.05}}
SLIDE = {"shear": {"by": [0.0016, 0.0], "step": 0.0016, "speed": 0.001, "settle": 0.1}}


def touch(name="one", indenter="ball", position=(0.001, -0.002), steps=(PRESS, {"dwell": {"time": 1.0}}), **more):
    return {
        "name": name,
        "sensor": "D1",
        "indenter": indenter,
        "position": list(position),
        "steps": list(steps),
        **more,
    }


def world(hidden=(), trajectories=(), **changes):
    document = {
        "format": "tactiledata-scenario/1",
        "seed": 5,
        "sensors": {"D1": {"background": "digit-bg-0"}},
        "indenters": {
            "ball": {"shape": "sphere", "radius": 0.004},
            "small": {"shape": "sphere", "radius": 0.002},
            "punch": {"shape": "cylinder_flat", "radius": 0.003},
        },
        "imperfections": QUIET,
        "streams": {"joints": 0, "tcp": 100, "wrench": 100, "arm_wrench": 0},
        "recordings": {"tare": "none"},
        "trajectories": list(trajectories) or [touch()],
        "hidden": list(hidden),
        **changes,
    }
    return load_scenario(document)


@dataclass(frozen=True)
class Log:
    """A log that was played: who plays, and the force readings (n, 6), stamps (n,) and seconds (n,) of its samples."""

    scenario: Scenario
    performance: PlayedLog
    readings: np.ndarray
    stamps: np.ndarray
    seconds: np.ndarray

    @property
    def in_air(self):
        """(n,): samples of this log without contact, with room to settle."""
        hit = np.abs(self.performance.wrench(self._host)).any(axis=1)
        return ~np.convolve(hit, np.ones(41), mode="same").astype(bool)

    @property
    def _host(self):
        return self.performance.start_ns + np.rint(self.seconds * 1e9).astype(np.int64)


def played(hidden=(), trajectories=(), **changes):
    scenario = world(hidden, trajectories, **changes)
    rig_setup = RigSetup(scenario)
    ((name, group),) = log_groups(scenario)
    performance = rig_setup.play(group, 0, scenario.start_ns)
    wrench = sample(rig_setup, name, 0, performance).signals["wrench"]
    seconds = (wrench.host_ns - performance.start_ns) * 1e-9
    return Log(scenario, performance, wrench.values, wrench.stamp_ns, seconds)


def contact_of(hidden=(), **changes):
    """Times (n,), phases (n,), wrench (n, 6) on the indenter, slipping (n,), and the play, of a single touch."""
    (play,) = played(hidden, **changes).performance.plays
    times = contact_times(play.path)
    phases = np.full(len(times), "", dtype=object)
    for start, end, name in play.path.phases:
        phases[(times >= start) & (times <= end)] = name
    return times, phases, play.contact.wrench, play.contact.slipping, play


def strong(effect, **parameters):
    return {"effect": effect, "strength": "strong", **({"parameters": parameters} if parameters else {})}


def stated(effect, **parameters):
    return {"effect": effect, "parameters": parameters}
