//! Types that every installation of ROS 2 has, for recordings that do not define theirs: those before
//! the release Iron in `.db3`. Fields in their order, as the packages of the same names define them.

/// The fields of a type, a line each.
pub(super) fn fields(name: &str) -> Option<&'static str> {
    let found = TYPES.iter().find(|(known, _)| *known == name);
    found.map(|(_, fields)| *fields)
}

const TYPES: [(&str, &str); 42] = [
    ("builtin_interfaces/Time", "int32 sec\nuint32 nanosec"),
    ("builtin_interfaces/Duration", "int32 sec\nuint32 nanosec"),
    (
        "std_msgs/Header",
        "builtin_interfaces/Time stamp\nstring frame_id",
    ),
    ("std_msgs/Bool", "bool data"),
    ("std_msgs/Int8", "int8 data"),
    ("std_msgs/Int16", "int16 data"),
    ("std_msgs/Int32", "int32 data"),
    ("std_msgs/Int64", "int64 data"),
    ("std_msgs/UInt8", "uint8 data"),
    ("std_msgs/UInt16", "uint16 data"),
    ("std_msgs/UInt32", "uint32 data"),
    ("std_msgs/UInt64", "uint64 data"),
    ("std_msgs/Float32", "float32 data"),
    ("std_msgs/Float64", "float64 data"),
    (
        "std_msgs/MultiArrayDimension",
        "string label\nuint32 size\nuint32 stride",
    ),
    (
        "std_msgs/MultiArrayLayout",
        "MultiArrayDimension[] dim\nuint32 data_offset",
    ),
    (
        "std_msgs/Float32MultiArray",
        "MultiArrayLayout layout\nfloat32[] data",
    ),
    (
        "std_msgs/Float64MultiArray",
        "MultiArrayLayout layout\nfloat64[] data",
    ),
    (
        "std_msgs/Int32MultiArray",
        "MultiArrayLayout layout\nint32[] data",
    ),
    ("geometry_msgs/Vector3", "float64 x\nfloat64 y\nfloat64 z"),
    ("geometry_msgs/Point", "float64 x\nfloat64 y\nfloat64 z"),
    (
        "geometry_msgs/Quaternion",
        "float64 x\nfloat64 y\nfloat64 z\nfloat64 w",
    ),
    (
        "geometry_msgs/Pose",
        "Point position\nQuaternion orientation",
    ),
    ("geometry_msgs/Twist", "Vector3 linear\nVector3 angular"),
    ("geometry_msgs/Accel", "Vector3 linear\nVector3 angular"),
    ("geometry_msgs/Wrench", "Vector3 force\nVector3 torque"),
    (
        "geometry_msgs/Transform",
        "Vector3 translation\nQuaternion rotation",
    ),
    (
        "geometry_msgs/Vector3Stamped",
        "std_msgs/Header header\nVector3 vector",
    ),
    (
        "geometry_msgs/PoseStamped",
        "std_msgs/Header header\nPose pose",
    ),
    (
        "geometry_msgs/TwistStamped",
        "std_msgs/Header header\nTwist twist",
    ),
    (
        "geometry_msgs/AccelStamped",
        "std_msgs/Header header\nAccel accel",
    ),
    (
        "geometry_msgs/WrenchStamped",
        "std_msgs/Header header\nWrench wrench",
    ),
    (
        "geometry_msgs/TransformStamped",
        "std_msgs/Header header\nstring child_frame_id\nTransform transform",
    ),
    (
        "geometry_msgs/PoseWithCovariance",
        "Pose pose\nfloat64[36] covariance",
    ),
    (
        "geometry_msgs/TwistWithCovariance",
        "Twist twist\nfloat64[36] covariance",
    ),
    (
        "nav_msgs/Odometry",
        "std_msgs/Header header\nstring child_frame_id\n\
         geometry_msgs/PoseWithCovariance pose\ngeometry_msgs/TwistWithCovariance twist",
    ),
    (
        "sensor_msgs/JointState",
        "std_msgs/Header header\nstring[] name\n\
         float64[] position\nfloat64[] velocity\nfloat64[] effort",
    ),
    (
        "sensor_msgs/Imu",
        "std_msgs/Header header\n\
         geometry_msgs/Quaternion orientation\nfloat64[9] orientation_covariance\n\
         geometry_msgs/Vector3 angular_velocity\nfloat64[9] angular_velocity_covariance\n\
         geometry_msgs/Vector3 linear_acceleration\nfloat64[9] linear_acceleration_covariance",
    ),
    (
        "sensor_msgs/MagneticField",
        "std_msgs/Header header\n\
         geometry_msgs/Vector3 magnetic_field\nfloat64[9] magnetic_field_covariance",
    ),
    (
        "trajectory_msgs/JointTrajectoryPoint",
        "float64[] positions\nfloat64[] velocities\nfloat64[] accelerations\nfloat64[] effort\n\
         builtin_interfaces/Duration time_from_start",
    ),
    (
        "trajectory_msgs/JointTrajectory",
        "std_msgs/Header header\nstring[] joint_names\nJointTrajectoryPoint[] points",
    ),
    (
        "tf2_msgs/TFMessage",
        "geometry_msgs/TransformStamped[] transforms",
    ),
];

#[cfg(test)]
mod tests {
    use super::super::Definition;
    use super::*;

    #[test]
    fn every_known_type_is_made_of_known_types() {
        for (name, _) in TYPES {
            Definition::known(name).unwrap();
        }
    }
}
