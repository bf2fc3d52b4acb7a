"""The messages of ROS 2 that the checks use, as another implementation of DDS has them: by hand, field by field."""

from dataclasses import dataclass, field

from cyclonedds.idl import IdlStruct
from cyclonedds.idl.types import array, float32, float64, int8, int32, int64, sequence, uint8, uint32, uint64


def of(package, name, kind="msg"):
    return f"{package}::{kind}::dds_::{name}_"


@dataclass
class Time(IdlStruct, typename=of("builtin_interfaces", "Time")):
    sec: int32 = 0
    nanosec: uint32 = 0


@dataclass
class Duration(IdlStruct, typename=of("builtin_interfaces", "Duration")):
    sec: int32
    nanosec: uint32


@dataclass
class Header(IdlStruct, typename=of("std_msgs", "Header")):
    stamp: Time
    frame_id: str


@dataclass
class Text(IdlStruct, typename=of("std_msgs", "String")):
    data: str


@dataclass
class ColorRGBA(IdlStruct, typename=of("std_msgs", "ColorRGBA")):
    r: float32
    g: float32
    b: float32
    a: float32


@dataclass
class Point(IdlStruct, typename=of("geometry_msgs", "Point")):
    x: float64
    y: float64
    z: float64


@dataclass
class Vector3(IdlStruct, typename=of("geometry_msgs", "Vector3")):
    x: float64
    y: float64
    z: float64


@dataclass
class Quaternion(IdlStruct, typename=of("geometry_msgs", "Quaternion")):
    x: float64
    y: float64
    z: float64
    w: float64


@dataclass
class Pose(IdlStruct, typename=of("geometry_msgs", "Pose")):
    position: Point
    orientation: Quaternion


@dataclass
class PoseStamped(IdlStruct, typename=of("geometry_msgs", "PoseStamped")):
    header: Header
    pose: Pose


@dataclass
class PoseArray(IdlStruct, typename=of("geometry_msgs", "PoseArray")):
    header: Header
    poses: sequence[Pose]


@dataclass
class Path(IdlStruct, typename=of("nav_msgs", "Path")):
    header: Header
    poses: sequence[PoseStamped]


@dataclass
class JointTrajectoryPoint(IdlStruct, typename=of("trajectory_msgs", "JointTrajectoryPoint")):
    positions: sequence[float64]
    velocities: sequence[float64]
    accelerations: sequence[float64]
    effort: sequence[float64]
    time_from_start: Duration


@dataclass
class JointTrajectory(IdlStruct, typename=of("trajectory_msgs", "JointTrajectory")):
    header: Header
    joint_names: sequence[str]
    points: sequence[JointTrajectoryPoint]


@dataclass
class Transform(IdlStruct, typename=of("geometry_msgs", "Transform")):
    translation: Vector3
    rotation: Quaternion


@dataclass
class TransformStamped(IdlStruct, typename=of("geometry_msgs", "TransformStamped")):
    header: Header
    child_frame_id: str
    transform: Transform


@dataclass
class TFMessage(IdlStruct, typename=of("tf2_msgs", "TFMessage")):
    transforms: sequence[TransformStamped]


@dataclass
class Image(IdlStruct, typename=of("sensor_msgs", "Image")):
    header: Header
    height: uint32
    width: uint32
    encoding: str
    is_bigendian: uint8
    step: uint32
    data: sequence[uint8]


@dataclass
class CompressedImage(IdlStruct, typename=of("sensor_msgs", "CompressedImage")):
    header: Header
    format: str
    data: sequence[uint8]


@dataclass
class RegionOfInterest(IdlStruct, typename=of("sensor_msgs", "RegionOfInterest")):
    x_offset: uint32 = 0
    y_offset: uint32 = 0
    height: uint32 = 0
    width: uint32 = 0
    do_rectify: bool = False


@dataclass
class CameraInfo(IdlStruct, typename=of("sensor_msgs", "CameraInfo")):
    header: Header
    height: uint32
    width: uint32
    distortion_model: str
    d: sequence[float64]
    k: array[float64, 9]
    r: array[float64, 9]
    p: array[float64, 12]
    binning_x: uint32 = 0
    binning_y: uint32 = 0
    roi: RegionOfInterest = field(default_factory=RegionOfInterest)


@dataclass
class PointField(IdlStruct, typename=of("sensor_msgs", "PointField")):
    name: str
    offset: uint32
    datatype: uint8
    count: uint32


@dataclass
class PointCloud2(IdlStruct, typename=of("sensor_msgs", "PointCloud2")):
    header: Header
    height: uint32
    width: uint32
    fields: sequence[PointField]
    is_bigendian: bool
    point_step: uint32
    row_step: uint32
    data: sequence[uint8]
    is_dense: bool


@dataclass
class Octomap(IdlStruct, typename=of("octomap_msgs", "Octomap")):
    header: Header
    binary: bool
    id: str
    resolution: float64
    data: sequence[int8]


@dataclass
class UVCoordinate(IdlStruct, typename=of("visualization_msgs", "UVCoordinate")):
    u: float32
    v: float32


@dataclass
class MeshFile(IdlStruct, typename=of("visualization_msgs", "MeshFile")):
    filename: str
    data: sequence[uint8]


@dataclass
class Marker(IdlStruct, typename=of("visualization_msgs", "Marker")):
    header: Header
    ns: str
    id: int32
    type: int32
    action: int32
    pose: Pose
    scale: Vector3
    color: ColorRGBA
    lifetime: Duration
    frame_locked: bool
    points: sequence[Point]
    colors: sequence[ColorRGBA]
    texture_resource: str
    texture: CompressedImage
    uv_coordinates: sequence[UVCoordinate]
    text: str
    mesh_resource: str
    mesh_file: MeshFile
    mesh_use_embedded_materials: bool


@dataclass
class MarkerArray(IdlStruct, typename=of("visualization_msgs", "MarkerArray")):
    markers: sequence[Marker]


# Services as rmw_cyclonedds has them: who asks, and the number of the request, before the content.
@dataclass
class TriggerRequest(IdlStruct, typename=of("std_srvs", "Trigger_Request", "srv")):
    client: uint64
    number: int64
    nothing: uint8 = 0


@dataclass
class TriggerReply(IdlStruct, typename=of("std_srvs", "Trigger_Response", "srv")):
    client: uint64
    number: int64
    success: bool
    message: str
