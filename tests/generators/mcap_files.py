"""MCAP recordings of a touch in every encoding and chunking, with the truth that went into them, and ways to harm them.

Run as a script to look at one: ``python mcap_files.py FILE [ros2msg|ros2idl|ros1|protobuf|json]``.
"""

import base64
import json
import struct
import sys
from functools import cache
from pathlib import Path

import cv2
import numpy as np
from mcap.writer import CompressionType, Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

START = 1_700_000_000_123_456_789
"""Log time of the first message, ns: odd on purpose, no float keeps it."""
STEP = 10_000_000
SERIAL = "D20542"
JOINTS = ("elbow", "shoulder_lift", "shoulder_pan", "wrist_1", "wrist_2", "wrist_3")
"""In the alphabetical order in which drivers publish them, which is not the order from base to wrist."""
JOINT_ORDER = (2, 1, 0, 3, 4, 5)
TOPICS = {
    "wrench": "/robotiq_force_torque_sensor_broadcaster/wrench",
    "ur_wrench": "/force_torque_sensor_broadcaster/wrench",
    "tcp": "/tcp_pose_broadcaster/pose",
    "joints": "/joint_states",
    "digit": "/digit/camera/color",
}
KINDS = {
    "wrench": "geometry_msgs/msg/WrenchStamped",
    "ur_wrench": "geometry_msgs/msg/WrenchStamped",
    "tcp": "geometry_msgs/msg/PoseStamped",
    "joints": "sensor_msgs/msg/JointState",
    "image": "sensor_msgs/msg/Image",
    "compressed": "sensor_msgs/msg/CompressedImage",
    "tf": "tf2_msgs/msg/TFMessage",
    "ft_sensor": "robotiq_ft_sensor/msg/ft_sensor",
}
FRAMES = {"wrench": "robotiq_ft_frame_id", "ur_wrench": "tool0", "tcp": "base", "joints": "base_link"}
COMPRESSIONS = {"none": CompressionType.NONE, "lz4": CompressionType.LZ4, "zstd": CompressionType.ZSTD}


@cache
def store(ros1=False):
    """Message types of ROS 2 Humble or ROS 1 Noetic, with the Robotiq driver's own type."""
    types = get_typestore(Stores.ROS1_NOETIC if ros1 else Stores.ROS2_HUMBLE)
    lines = "".join(f"float32 {name}\n" for name in ("Fx", "Fy", "Fz", "Mx", "My", "Mz"))
    types.register(get_types_from_msg(lines, KINDS["ft_sensor"]))
    return types


def picture(index, height=32, width=24):
    """A colour picture (H, W, 3), RGB, with a mark that moves with the index."""
    rng = np.random.default_rng(index)
    image = rng.integers(0, 40, (height, width, 3), dtype=np.uint8)
    image[index % height, :, 0] = 250
    return image


def encoded(image, suffix=".png"):
    """PNG or JPEG bytes of an RGB picture."""
    done, payload = cv2.imencode(suffix, image[:, :, ::-1])
    assert done
    return payload.tobytes()


def stamp(ns, ros1=False):
    """A builtin_interfaces/Time."""
    return store(ros1).types["builtin_interfaces/msg/Time"](sec=ns // 10**9, nanosec=ns % 10**9)


def header(ns, frame, ros1=False):
    """A std_msgs/Header, with the sequence number that ROS 1 has."""
    make = store(ros1).types["std_msgs/msg/Header"]
    return make(seq=0, stamp=stamp(ns, True), frame_id=frame) if ros1 else make(stamp=stamp(ns), frame_id=frame)


def ros_message(stream, ns, values, frame=None, ros1=False, names=None):
    """A message object of a stream of numbers, from a row in the toolkit's order."""
    types = store(ros1).types
    head = header(ns, FRAMES.get(stream, "") if frame is None else frame, ros1)
    row = [float(value) for value in values]
    vector = types["geometry_msgs/msg/Vector3"]
    if stream in ("wrench", "ur_wrench"):
        wrench = types["geometry_msgs/msg/Wrench"](force=vector(*row[:3]), torque=vector(*row[3:]))
        return types[KINDS[stream]](header=head, wrench=wrench)
    if stream == "tcp":
        pose = types["geometry_msgs/msg/Pose"](
            position=types["geometry_msgs/msg/Point"](*row[:3]),
            orientation=types["geometry_msgs/msg/Quaternion"](*row[3:]),
        )
        return types[KINDS[stream]](header=head, pose=pose)
    positions = np.array(row)[np.argsort(JOINT_ORDER)] if names is None else np.array(row)
    return types[KINDS["joints"]](
        header=head,
        name=[f"{name}_joint" for name in JOINTS] if names is None else list(names),
        position=positions,
        velocity=np.zeros(len(positions)),
        effort=np.zeros(0),
    )


def tree_message(ns, transforms):
    """A tf2_msgs/TFMessage of (frame, child_frame, pose) entries."""
    types = store().types
    entries = [
        types["geometry_msgs/msg/TransformStamped"](
            header=header(ns, frame),
            child_frame_id=child,
            transform=types["geometry_msgs/msg/Transform"](
                translation=types["geometry_msgs/msg/Vector3"](*map(float, pose[:3])),
                rotation=types["geometry_msgs/msg/Quaternion"](*map(float, pose[3:])),
            ),
        )
        for frame, child, pose in transforms
    ]
    return types[KINDS["tf"]](transforms=entries)


def image_message(ns, image, encoding="bgr8", frame="digit", ros1=False, step=None, payload=None):
    """A sensor_msgs/Image of an RGB picture."""
    height, width = image.shape[:2]
    pixels = image[:, :, ::-1] if encoding.startswith("bgr") else image
    if encoding.endswith("a8"):
        pixels = np.concatenate([pixels, np.full((height, width, 1), 77, np.uint8)], axis=2)
    row = pixels[0].size if step is None else step
    content = np.zeros((height, row), np.uint8)
    content[:, : pixels[0].size] = pixels.reshape(height, -1)
    data = content.ravel() if payload is None else np.frombuffer(payload, np.uint8)
    return store(ros1).types[KINDS["image"]](
        header=header(ns, frame, ros1),
        height=height,
        width=width,
        encoding=encoding,
        is_bigendian=0,
        step=row,
        data=data,
    )


def compressed_message(ns, payload, style="jpeg", frame="digit", ros1=False):
    """A sensor_msgs/CompressedImage."""
    return store(ros1).types[KINDS["compressed"]](
        header=header(ns, frame, ros1), format=style, data=np.frombuffer(payload, np.uint8)
    )


def schema_text(kind, encoding="ros2msg"):
    """A schema as writers put it into an MCAP."""
    if encoding == "ros2idl":
        return idl_text(kind)
    text, _ = store(encoding == "ros1msg").generate_msgdef(kind, ros_version=1 if encoding == "ros1msg" else 2)
    return text


def idl_text(kind):
    """The definition of a type and of all that it uses, in IDL, as rosbag2 writes it."""
    fielddefs, parts, seen = store().fielddefs, [], set()

    def visit(name):
        if name in seen:
            return
        seen.add(name)
        package, _, short = name.rpartition("/")
        lines = []
        for field, (node, inner) in fielddefs[name][1]:
            base, after, before = inner, "", ""
            if node in (3, 4):
                (node, base), count = inner
                before, after = ("", f"[{count}]") if count else ("sequence<", ">")
            if node == 2:
                visit(base)
            spelled = base.replace("/", "::") if node == 2 else IDL_NAMES.get(base[0], base[0])
            whole = f"{before}{spelled}{after}" if before else spelled
            lines.append(f"      {whole} {field}{'' if before else after};")
        modules = package.split("/")
        body = "\n".join(lines)
        opening = " ".join(f"module {module} {{" for module in modules)
        parts.append(
            f"{'=' * 80}\nIDL: {name}\n{opening}\n    struct {short} {{\n{body}\n    }};\n{'};' * len(modules)}\n"
        )

    visit(kind)
    return "\n".join(reversed(parts))


IDL_NAMES = {"float64": "double", "float32": "float", "bool": "boolean"}


class Tape:
    """An MCAP that is being written, ROS messages by stream name, anything else by bytes.

    Parameters
    ----------
    path : Path
    encoding : "ros2msg", "ros2idl" or "ros1"
    compression : "none", "lz4" or "zstd"
    options
        Of `mcap.writer.Writer`.
    """

    def __init__(self, path, encoding="ros2msg", compression="zstd", **options):
        options.setdefault("chunk_size", 4096)
        self.path, self.encoding = Path(path), encoding
        self.is_ros1 = encoding == "ros1"
        self._stream = self.path.open("wb")
        self.writer = Writer(self._stream, compression=COMPRESSIONS[compression], **options)
        self.writer.start(profile="ros1" if self.is_ros1 else "ros2", library="tests")
        self._schemas, self._channels = {}, {}

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.writer.finish()
        self._stream.close()

    def channel(self, topic, kind, schema_encoding, message_encoding, text):
        """The id of a channel, registered once."""
        if (kind, text) not in self._schemas:
            self._schemas[(kind, text)] = self.writer.register_schema(kind, schema_encoding, text)
        key = (topic, kind, message_encoding)
        if key not in self._channels:
            self._channels[key] = self.writer.register_channel(topic, message_encoding, self._schemas[(kind, text)])
        return self._channels[key]

    def raw(
        self, topic, log_ns, payload, kind="", schema_encoding="", message_encoding="json", text=b"", publish_ns=None
    ):
        """A message of any encoding."""
        channel = self.channel(topic, kind, schema_encoding, message_encoding, text)
        self.writer.add_message(channel, log_ns, bytes(payload), log_ns if publish_ns is None else publish_ns)

    def ros(self, topic, log_ns, message, kind, publish_ns=None):
        """A ROS message object."""
        schema_encoding = "ros1msg" if self.is_ros1 else self.encoding
        text = _cached_text(kind, schema_encoding)
        if self.is_ros1:
            payload, name = store(True).serialize_ros1(message, kind), kind.replace("/msg/", "/")
        else:
            payload, name = store().serialize_cdr(message, kind), kind
        self.raw(topic, log_ns, payload, name, schema_encoding, "ros1" if self.is_ros1 else "cdr", text, publish_ns)

    def signal(self, stream, log_ns, stamp_ns, values, frame=None, topic=None, publish_ns=None, names=None):
        """A row of wrench, ur_wrench, tcp or joints."""
        message = ros_message(stream, stamp_ns, values, frame, self.is_ros1, names)
        self.ros(topic or TOPICS[stream], log_ns, message, KINDS[stream], publish_ns)

    def image(self, log_ns, stamp_ns, image, topic=None, **options):
        """A raw image."""
        message = image_message(stamp_ns, image, ros1=self.is_ros1, **options)
        self.ros(topic or TOPICS["digit"], log_ns, message, KINDS["image"])

    def compressed(self, log_ns, stamp_ns, payload, topic=None, **options):
        """A compressed image."""
        message = compressed_message(stamp_ns, payload, ros1=self.is_ros1, **options)
        self.ros(topic or TOPICS["digit"], log_ns, message, KINDS["compressed"])

    def describe(self, document, attachments=()):
        """The description and its backgrounds, as the rig writes them."""
        for name, payload in dict(attachments).items():
            self.writer.add_attachment(START, START, name, "image/png", payload)
        self.writer.add_metadata("tactiledata", {"log": json.dumps(document)})


@cache
def _cached_text(kind, schema_encoding):
    return schema_text(kind, schema_encoding).encode()


def numbers(count, width, seed=0):
    """Rows (count, width) that no two streams share; quaternions where there are seven."""
    values = np.random.default_rng(seed).normal(size=(count, width))
    if width == 7:
        values[:, 3:] /= np.linalg.norm(values[:, 3:], axis=1, keepdims=True)
    return values


def description(serial=SERIAL, count=0, background=None):
    """A description with one sensor and ``count`` trajectories of ten samples each."""
    sensor = {"model": "digit", **({"background": background} if background else {})}
    trajectories = [
        {
            "trajectory": f"t{index}",
            "start_ns": START + index * 10 * STEP,
            "end_ns": START + (index + 1) * 10 * STEP,
            "sensor": serial,
            "spot": index,
        }
        for index in range(count)
    ]
    return {
        "format": "tactiledata-log/1",
        "sensors": {serial: sensor},
        **({"trajectories": trajectories} if count else {}),
    }


def touch(path, encoding="ros2msg", compression="zstd", count=40, **options):
    """A recording with all streams: ``count`` samples of each signal and a picture every fourth; returns the truth."""
    truth = {
        "log": START + STEP * np.arange(count, dtype=np.int64),
        "header": START + STEP * np.arange(count, dtype=np.int64) - 3_000_001,
        "publish": START + STEP * np.arange(count, dtype=np.int64) - 1_000_001,
        "wrench": numbers(count, 6, 1),
        "ur_wrench": numbers(count, 6, 2),
        "tcp": numbers(count, 7, 3),
        "joints": numbers(count, 6, 4),
        "pictures": [picture(index) for index in range(0, count, 4)],
    }
    background = encoded(picture(999))
    with Tape(path, encoding, compression, **options) as tape:
        for index in range(count):
            log, head, publish = (int(truth[name][index]) for name in ("log", "header", "publish"))
            for stream in ("wrench", "ur_wrench", "tcp", "joints"):
                tape.signal(stream, log, head, truth[stream][index], publish_ns=publish)
            if index % 4 == 0:
                tape.image(log, head, truth["pictures"][index // 4])
        tape.describe(description(count=2, background="bg/one.png"), {"bg/one.png": background})
    truth["background"] = picture(999)
    return truth


def long_touch(path, compression="zstd", chunked=True, count=6600, **options):
    """A wrench recording of ``count`` messages for the table of damage; returns the values."""
    values = numbers(count, 6, 7)
    kind = KINDS["wrench"]
    payload = bytearray(store().serialize_cdr(ros_message("wrench", START, values[0]), kind))
    with Tape(path, "ros2msg", compression, use_chunking=chunked, **{"chunk_size": 4960, **options}) as tape:
        for index in range(count):
            stamp_ns = START + STEP * index
            struct.pack_into("<iI", payload, 4, stamp_ns // 10**9, stamp_ns % 10**9)
            struct.pack_into("<6d", payload, len(payload) - 48, *values[index])
            tape.raw(TOPICS["wrench"], stamp_ns, payload, kind, "ros2msg", "cdr", _cached_text(kind, "ros2msg"))
    return values


# protobuf and JSON


@cache
def proto_file():
    """A FileDescriptorSet with a compressed image, a raw image, a pose and a wrench."""
    from google.protobuf import descriptor_pb2

    kind = descriptor_pb2.FieldDescriptorProto
    files = descriptor_pb2.FileDescriptorSet()
    file = files.file.add(name="lab.proto", package="foxglove", syntax="proto3")

    def message(name, **fields):
        entry = file.message_type.add(name=name)
        for number, (field, base) in enumerate(fields.items(), start=1):
            made = entry.field.add(name=field, number=number, label=kind.LABEL_OPTIONAL)
            if isinstance(base, str):
                made.type, made.type_name = kind.TYPE_MESSAGE, f".foxglove.{base}"
            else:
                made.type = base

    double, text, blob = kind.TYPE_DOUBLE, kind.TYPE_STRING, kind.TYPE_BYTES
    message("Timestamp", seconds=kind.TYPE_INT64, nanos=kind.TYPE_INT32)
    message("Vector3", x=double, y=double, z=double)
    message("Quaternion", x=double, y=double, z=double, w=double)
    message("Pose", position="Vector3", orientation="Quaternion")
    message("CompressedImage", timestamp="Timestamp", frame_id=text, data=blob, format=text)
    size = kind.TYPE_FIXED32
    message(
        "RawImage", timestamp="Timestamp", frame_id=text, width=size, height=size, encoding=text, step=size, data=blob
    )
    message("PoseInFrame", timestamp="Timestamp", frame_id=text, pose="Pose")
    message("LabWrench", timestamp="Timestamp", frame_id=text, force="Vector3", torque="Vector3")
    return files


def proto_payload(kind, document):
    """Protobuf bytes of a message given as a dictionary; bytes stay bytes."""
    from google.protobuf import descriptor_pool, json_format, message_factory

    pool = descriptor_pool.DescriptorPool()
    for file in proto_file().file:
        pool.Add(file)
    made = message_factory.GetMessageClass(pool.FindMessageTypeByName(kind))()
    return json_format.ParseDict(_json_bytes(document), made).SerializeToString()


def _json_bytes(document):
    return {
        key: base64.b64encode(value).decode() if isinstance(value, bytes) else value for key, value in document.items()
    }


def foxglove_touch(path, encoding, count=12, compression="zstd"):
    """Images, poses and wrenches as ``protobuf`` or ``json``; returns the truth and a mapping that names them."""
    truth = {"wrench": numbers(count, 6, 1), "tcp": numbers(count, 7, 3), "payloads": [], "pictures": []}
    seconds, nanos = ("seconds", "nanos") if encoding == "protobuf" else ("sec", "nsec")
    with Tape(path, compression=compression) as tape:

        def put(topic, kind, log_ns, document):
            if encoding == "protobuf":
                text = proto_file().SerializeToString()
                tape.raw(topic, log_ns, proto_payload(kind, document), kind, "protobuf", "protobuf", text)
            else:
                payload = json.dumps(_json_bytes(document)).encode()
                tape.raw(topic, log_ns, payload, kind, "jsonschema", "json", b"{}")

        for index in range(count):
            log_ns = START + index * STEP
            common = {"timestamp": {seconds: log_ns // 10**9, nanos: log_ns % 10**9}}
            force, pose = truth["wrench"][index].tolist(), truth["tcp"][index].tolist()
            vectors = {
                name: dict(zip("xyz", part, strict=True))
                for name, part in (("force", force[:3]), ("torque", force[3:]))
            }
            put("/ft", "foxglove.LabWrench", log_ns, {**common, "frame_id": "ft", **vectors})
            place = {
                "position": dict(zip("xyz", pose[:3], strict=True)),
                "orientation": dict(zip("xyzw", pose[3:], strict=True)),
            }
            put("/pose", "foxglove.PoseInFrame", log_ns, {**common, "frame_id": "base", "pose": place})
            image = picture(index)
            payload = encoded(image, ".jpg")
            shown = {**common, "frame_id": "digit", "data": payload, "format": "jpeg"}
            put("/digit/image", "foxglove.CompressedImage", log_ns, shown)
            raw = {"width": 24, "height": 32, "encoding": "rgb8", "step": 72, "data": image.tobytes()}
            put("/tactile/raw", "foxglove.RawImage", log_ns, {**common, "frame_id": "digit", **raw})
            truth["payloads"].append(payload)
            truth["pictures"].append(image)
    fields = [f"{name}.{axis}" for name in ("force", "torque") for axis in "xyz"]
    truth["mapping"] = {
        "format": "tactiledata-mapping/1",
        "signals": {"wrench": {"topic": "/ft", "fields": fields}, "tcp": {"topic": "/pose"}},
    }
    return truth


if __name__ == "__main__":
    chosen = sys.argv[2] if len(sys.argv) > 2 else "ros2msg"
    if chosen in ("protobuf", "json"):
        foxglove_touch(sys.argv[1], chosen)
    else:
        touch(sys.argv[1], chosen)
