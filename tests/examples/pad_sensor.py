"""A tactile sensor of one's own: one frozen description, every number with its source."""

from tactiledata.sensors.base import GelGeometry, Sensor, TactileCamera

PAD = Sensor(
    name="pad",
    title="Laboratory pad",
    maker="our laboratory",
    kind="tactile",
    gel=GelGeometry(outline=(0.020, 0.020), thickness=0.003, edge_thickness=0.003),
    camera=TactileCamera(shape=(240, 240), field_of_view=(0.020, 0.020), frame_rate=30.0),
    sources={
        "gel.outline": "drawing of the mould",
        "gel.thickness": "calliper, five places, ±0.1 mm",
        "gel.edge_thickness": "calliper; the pad is flat",
        "camera.shape": "camera driver",
        "camera.field_of_view": "a ruler pressed onto the pad",
        "camera.frame_rate": "camera driver",
    },
)
