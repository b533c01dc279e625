"""Description of GelSight R1.5 as in the ObjectFolder calibration pack: a flat pad, a small picture."""

from tactiledata.sensors.base import GelGeometry, Sensor, TactileCamera

_PACK = "calibration pack of rhgao/ObjectFolder (CC BY 4.0)"

GELSIGHT_R15 = Sensor(
    name="gelsight_r15",
    title="GelSight R1.5",
    maker="GelSight",
    kind="tactile",
    gel=GelGeometry(outline=(120 * 0.1245e-3, 160 * 0.1245e-3), thickness=0.004, edge_thickness=0.004),
    camera=TactileCamera(shape=(120, 160), field_of_view=(120 * 0.1245e-3, 160 * 0.1245e-3), frame_rate=60.0),
    sources={
        "gel.outline": "our own lower bound: the field of view, as nothing beyond it is seen in the " + _PACK,
        "gel.thickness": "our own estimate, of the order of other GelSight pads; not measured",
        "gel.edge_thickness": "equal to the thickness: the pad is flat",
        "camera.shape": _PACK + ": 120 rows x 160 columns (BGR there; RGB here)",
        "camera.field_of_view": _PACK + ": 0.1245 mm a pixel in both directions",
        "camera.frame_rate": "our own estimate; the pack holds single pictures without time stamps",
    },
)
