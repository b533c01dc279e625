"""Missing physics: what a simulation may have left out, one effect a file and one line in the table below."""

from tactiledata.registry import Registry

EFFECTS = Registry(
    "effect",
    {
        "mount_offset": "tactiledata.effects.mount_offset:MountOffset",
        "arm_compliance": "tactiledata.effects.arm_compliance:ArmCompliance",
        "stem_bending": "tactiledata.effects.stem_bending:StemBending",
        "thickness": "tactiledata.effects.thickness:Thickness",
        "dome": "tactiledata.effects.dome:Dome",
        "soft_region": "tactiledata.effects.soft_region:SoftRegion",
        "pad_edge": "tactiledata.effects.pad_edge:PadEdge",
        "strain_stiffening": "tactiledata.effects.strain_stiffening:StrainStiffening",
        "skin": "tactiledata.effects.skin:Skin",
        "mullins": "tactiledata.effects.mullins:Mullins",
        "heating": "tactiledata.effects.heating:Heating",
        "wear": "tactiledata.effects.wear:Wear",
        "area_friction": "tactiledata.effects.area_friction:AreaFriction",
        "rate_friction": "tactiledata.effects.rate_friction:RateFriction",
        "static_friction": "tactiledata.effects.static_friction:StaticFriction",
        "partial_slip": "tactiledata.effects.partial_slip:PartialSlip",
        "adhesion": "tactiledata.effects.adhesion:Adhesion",
        "relaxation": "tactiledata.effects.relaxation:Relaxation",
        "clock_skew": "tactiledata.effects.clock_skew:ClockSkew",
        "tool_weight": "tactiledata.effects.tool_weight:ToolWeight",
        "inertia": "tactiledata.effects.inertia:Inertia",
        "cable_drag": "tactiledata.effects.cable_drag:CableDrag",
        "frame_rotation": "tactiledata.effects.frame_rotation:FrameRotation",
        "gain_crosstalk": "tactiledata.effects.gain_crosstalk:GainCrosstalk",
        "sensor_drift": "tactiledata.effects.sensor_drift:SensorDrift",
        "lag": "tactiledata.effects.lag:Lag",
        "quantisation": "tactiledata.effects.quantisation:Quantisation",
        "clipping": "tactiledata.effects.clipping:Clipping",
    },
    group="tactiledata.effects",
)
"""In the order in which effects of one slot act: partial slip mixes all friction before it, clipping comes last."""
