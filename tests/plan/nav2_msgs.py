"""Stand-in for nav2_msgs, of which no wheel exists: its fields in Jazzy, as far as the nodes use them."""

import math

from rocs_bt.ros2.ros_link import RosField

STAMPED, PATH, DURATION = "geometry_msgs/msg/PoseStamped", "nav_msgs/msg/Path", "builtin_interfaces/msg/Duration"
TEXT, NUMBER, TRUTH, WORD = RosField("string"), RosField("float32"), RosField("bool"), RosField("uint16")
NAV2_MSGS = {
    STAMPED: {"header": RosField("std_msgs/msg/Header"), "pose": RosField("geometry_msgs/msg/Pose")},
    "std_msgs/msg/Header": {"stamp": RosField("builtin_interfaces/msg/Time"), "frame_id": TEXT},
    "geometry_msgs/msg/Pose": {
        "position": RosField("geometry_msgs/msg/Vector3"),
        "orientation": RosField("geometry_msgs/msg/Quaternion"),
    },
    "geometry_msgs/msg/Quaternion": {axis: RosField("float64") for axis in "xyzw"},
    PATH: {"header": RosField("std_msgs/msg/Header"), "poses": RosField(STAMPED, array=True)},
    DURATION: {"sec": RosField("int32"), "nanosec": RosField("uint32")},
    "nav_msgs/msg/Goals": {"header": RosField("std_msgs/msg/Header"), "goals": RosField(STAMPED, array=True)},
    "nav2_msgs/action/NavigateToPose_Goal": {"pose": RosField(STAMPED), "behavior_tree": TEXT},
    "nav2_msgs/action/NavigateToPose_Feedback": {"distance_remaining": NUMBER},
    "nav2_msgs/action/NavigateToPose_Result": {"error_code": WORD, "error_msg": TEXT},
    "nav2_msgs/action/NavigateThroughPoses_Goal": {"poses": RosField(STAMPED, array=True), "behavior_tree": TEXT},
    "nav2_msgs/action/ComputePathToPose_Goal": {
        "goal": RosField(STAMPED), "start": RosField(STAMPED), "planner_id": TEXT, "use_start": TRUTH,
    },
    "nav2_msgs/action/FollowPath_Goal": {"path": RosField(PATH), "controller_id": TEXT, "goal_checker_id": TEXT},
    "nav2_msgs/action/Spin_Goal": {"target_yaw": NUMBER, "time_allowance": RosField(DURATION)},
    "nav2_msgs/action/BackUp_Goal": {
        "target": RosField("geometry_msgs/msg/Vector3"), "speed": NUMBER, "time_allowance": RosField(DURATION),
        "disable_collision_checks": TRUTH,
    },
    "nav2_msgs/action/DriveOnHeading_Goal": {"target": RosField("geometry_msgs/msg/Vector3"), "speed": NUMBER},
    "nav2_msgs/action/Wait_Goal": {"time": RosField(DURATION)},
    "nav2_msgs/action/DockRobot_Goal": {
        "use_dock_id": TRUTH, "dock_id": TEXT, "dock_pose": RosField(STAMPED), "dock_type": TEXT,
        "max_staging_time": NUMBER, "navigate_to_staging_pose": TRUTH,
    },
    "nav2_msgs/action/UndockRobot_Goal": {"dock_type": TEXT, "max_undocking_time": NUMBER},
    "nav2_msgs/action/ComputePathThroughPoses_Goal": {
        "goals": RosField("nav_msgs/msg/Goals"), "start": RosField(STAMPED), "planner_id": TEXT, "use_start": TRUTH,
    },
    "nav2_msgs/action/SmoothPath_Goal": {
        "path": RosField(PATH), "smoother_id": TEXT, "max_smoothing_duration": RosField(DURATION),
        "check_for_collisions": TRUTH,
    },
    "nav2_msgs/action/AssistedTeleop_Goal": {"time_allowance": RosField(DURATION)},
    **{
        f"nav2_msgs/action/{name}_Goal": {
            "start_id": WORD, "start": RosField(STAMPED), "goal_id": WORD, "goal": RosField(STAMPED),
            "use_start": TRUTH, "use_poses": TRUTH,
        }
        for name in ("ComputeRoute", "ComputeAndTrackRoute")
    },
    "nav2_msgs/action/FollowObject_Goal": {
        "pose_topic": TEXT, "max_duration": RosField(DURATION), "tracked_frame": TEXT,
    },
    "action_msgs/srv/CancelGoal_Request": {"goal_info": RosField("action_msgs/msg/GoalInfo")},
    "action_msgs/msg/GoalInfo": {"stamp": RosField("builtin_interfaces/msg/Time")},
    "std_srvs/srv/Empty_Request": {},
    "nav2_msgs/srv/Toggle_Request": {"enable": TRUTH},
    "nav2_msgs/srv/GetCosts_Request": {"use_footprint": TRUTH, "poses": RosField(STAMPED, array=True)},
    "nav2_msgs/srv/IsPathValid_Request": {"path": RosField(PATH), "max_cost": WORD, "layer_name": TEXT},
    "nav2_msgs/srv/ClearEntireCostmap_Request": {"plugins": RosField("string", array=True)},
    "nav2_msgs/srv/ClearCostmapExceptRegion_Request": {"reset_distance": NUMBER},
    "nav2_msgs/srv/ClearCostmapAroundRobot_Request": {"reset_distance": NUMBER},
    "nav2_msgs/srv/ClearCostmapAroundPose_Request": {"pose": RosField(STAMPED), "reset_distance": NUMBER},
}  # fmt: skip  # fields of a message share lines

for _name in [name for name in NAV2_MSGS if name.endswith("_Goal")]:
    NAV2_MSGS.setdefault(_name.replace("_Goal", "_Feedback"), {})
    NAV2_MSGS.setdefault(_name.replace("_Goal", "_Result"), {})


def pose(x, y, yaw=0.0):
    turned = {"z": math.sin(yaw / 2), "w": math.cos(yaw / 2)}
    return {"header": {"frame_id": "map"}, "pose": {"position": {"x": x, "y": y}, "orientation": turned}}
