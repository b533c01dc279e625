"""Missing physics: which effects may a simulation have left out, and what would each change in a touch?

An effect is one file, in the folder of its slot, and one line in the table below. Read in this order:

- ``base`` and ``parameter``: what an effect declares, and what each of its numbers means, which of its values can be
  believed, and how far beyond them one is implausible; ``design`` interpolates between variants of the gel that the
  gel engine has played.
- ``touch``: what a recorded touch states, what an effect may change of it, and operators that several effects share.
- ``pose``, ``geometry``, ``material``, ``interface``, ``time``, ``sensor``: the effects, by slot, in the order in which
  they act.
- ``closed_form``: contacts in closed form, for previews, examples and tests.
- ``simulate``: settings of effects, and the simulator that plays a touch with them.

An effect imports ``base``, ``parameter`` and ``touch``, never another effect. Nothing here solves the gel: whoever
simulates implements ``touch.response.BaseResponse``.
"""

from tactiledata.registry import Registry

EFFECTS = Registry(
    "effect",
    {
        "mount_offset": "tactiledata.effects.pose.mount_offset:MountOffset",
        "arm_compliance": "tactiledata.effects.pose.arm_compliance:ArmCompliance",
        "stem_bending": "tactiledata.effects.pose.stem_bending:StemBending",
        "thickness": "tactiledata.effects.geometry.thickness:Thickness",
        "dome": "tactiledata.effects.geometry.dome:DomeCurvature",
        "soft_region": "tactiledata.effects.geometry.soft_region:SoftRegion",
        "pad_edge": "tactiledata.effects.geometry.pad_edge:PadEdge",
        "strain_stiffening": "tactiledata.effects.material.strain_stiffening:StrainStiffening",
        "skin": "tactiledata.effects.material.skin:Skin",
        "mullins": "tactiledata.effects.material.mullins:Mullins",
        "heating": "tactiledata.effects.material.heating:Heating",
        "wear": "tactiledata.effects.material.wear:Wear",
        "area_friction": "tactiledata.effects.interface.area_friction:AreaFriction",
        "rate_friction": "tactiledata.effects.interface.rate_friction:RateFriction",
        "static_friction": "tactiledata.effects.interface.static_friction:StaticFriction",
        "partial_slip": "tactiledata.effects.interface.partial_slip:PartialSlip",
        "adhesion": "tactiledata.effects.interface.adhesion:Adhesion",
        "relaxation": "tactiledata.effects.time.relaxation:Relaxation",
        "clock_skew": "tactiledata.effects.time.clock_skew:ClockSkew",
        "tool_weight": "tactiledata.effects.sensor.tool_weight:ToolWeight",
        "inertia": "tactiledata.effects.sensor.inertia:Inertia",
        "cable_drag": "tactiledata.effects.sensor.cable_drag:CableDrag",
        "frame_rotation": "tactiledata.effects.sensor.frame_rotation:FrameRotation",
        "gain_crosstalk": "tactiledata.effects.sensor.gain_crosstalk:GainCrosstalk",
        "sensor_drift": "tactiledata.effects.sensor.sensor_drift:SensorDrift",
        "lag": "tactiledata.effects.sensor.lag:Lag",
        "quantisation": "tactiledata.effects.sensor.quantisation:Quantisation",
        "clipping": "tactiledata.effects.sensor.clipping:Clipping",
    },
    group="tactiledata.effects",
)
"""Effects by name, in the order in which they act: partial slip mixes all friction before it, clipping comes last."""
