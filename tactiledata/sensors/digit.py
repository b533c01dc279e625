"""Description of DIGIT: a low-cost finger with a soft dome, a camera behind it and three coloured LEDs."""

from tactiledata.sensors.base import GelGeometry, Sensor, TactileCamera

_MESH = "measured on the published DIGIT gel mesh of wzaielamri/across_framework (MIT)"

DIGIT = Sensor(
    name="digit",
    title="DIGIT",
    maker="Meta AI, GelSight",
    kind="tactile",
    gel=GelGeometry(
        outline=(0.0184, 0.0250),
        thickness=0.00406,
        edge_thickness=0.0023,
        round_end=0.008,
        corner_radius=0.001,
        shore_00=75.0,
    ),
    camera=TactileCamera(shape=(320, 240), field_of_view=(0.019, 0.016), frame_rate=60.0),
    sources={
        "gel.outline": _MESH + ": 18.40 x 25.00 mm; the short side lies along x of the gel frame",
        "gel.thickness": _MESH + ": 4.06 mm in the middle",
        "gel.edge_thickness": _MESH
        + ": the dome falls to about 2.3 mm within 1 mm of the rim, on the short sides as on the long ones; the rounded"
        " rim itself is 1.9 to 2.0 mm high",
        "gel.round_end": _MESH + ": one short side is rounded, like half an ellipse 8 mm deep and 18.4 mm wide",
        "gel.corner_radius": _MESH + ": about 1 mm, at the other short side",
        "gel.shore_00": "the maker's figure as the SPLIT paper quotes it: 75 on the Shore 00 scale",
        "camera.shape": "facebookresearch/digit-interface, Digit.get_frame: QVGA, turned upright to 320 rows x 240"
        " columns (BGR there; RGB here)",
        "camera.frame_rate": "facebookresearch/digit-interface, Digit.connect: QVGA at 60 Hz; 30 Hz is usual too",
        "camera.field_of_view": "our own estimate: 19 x 16 mm, the sensing field quoted for the design (Lambeta et al."
        " 2020); differs from unit to unit by tenths of a millimetre and is not a calibration",
    },
)
