"""Description of Robotiq FT 300-S: the six-axis force-torque sensor between the flange of a UR arm and its tool."""

from tactiledata.sensors.base import ForceSpecification, Sensor

_MANUAL = "Robotiq FT 300-S instruction manual"

ROBOTIQ_FT300S = Sensor(
    name="robotiq_ft300s",
    title="Robotiq FT 300-S",
    maker="Robotiq",
    kind="force",
    force=ForceSpecification(
        force_range=300.0,
        torque_range=30.0,
        force_noise=0.1,
        torque_noise=0.005,
        force_quantum=0.01,
        torque_quantum=0.001,
        rate=100.0,
        seen_rates=(62.5, 100.0, 125.0),
    ),
    sources={
        "force.force_range": _MANUAL + ": +-300 N on each axis",
        "force.torque_range": _MANUAL + ": +-30 N m about each axis",
        "force.force_noise": "0.1 N, the resolution that selection guides quote; taken here as one standard deviation",
        "force.torque_noise": "our own estimate, the order of the maker's signal noise; check it on free air",
        "force.force_quantum": _MANUAL + ", data stream: 16-bit integers of 100 counts per N",
        "force.torque_quantum": _MANUAL + ", data stream: 16-bit integers of 1000 counts per N m",
        "force.rate": _MANUAL + ", data stream: 100 Hz",
        "force.seen_rates": "62.5 Hz in ros-industrial-attic/robotiq issue 124; 125 Hz where a robot controller's loop"
        " repeats readings",
    },
)
