"""What Nav2, slam_toolbox and robot_localization need of a simulated robot: its description, frames and covariances."""

import math
from xml.etree import ElementTree as xml

import mujoco
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from rocs_bt.base.geometry import Pose3
from rocs_bt.catalog import Catalog
from rocs_bt.devices.simulated import Gyro, Lidar, Orientation, Position, RangeCone, WheelSpeed
from rocs_bt.interfaces.device import Reading
from rocs_bt.ros2.devices.parameters import Ros2SensorParameters
from rocs_bt.ros2.messages.message_types import RANGE, SCAN
from rocs_bt.ros2.sim.publishers import FrameOptions
from rocs_bt.ros2.sim.wheel_odometry import WheelOdometry

from .test_sim_robot import TYPES, Stage, frames_of, pose_of

PARTS = np.ix_((0, 1, 5), (0, 1, 5))  # x, y and yaw
ROBOTS = [entry.name for entry in Catalog.here().list("robot") if not entry.name.endswith("_ros2")]
UNMEASURED = 1e6
SETTINGS = '<mujoco><compiler fusestatic="false" discardvisual="false" boundmass="1" boundinertia="1"/></mujoco>'


def parsed(text):
    """Model that MuJoCo's own reader of URDF makes of a description; MuJoCo needs masses, which a display does not."""
    return mujoco.MjModel.from_xml_string(text.replace("</robot>", f"{SETTINGS}</robot>"))


def transforms(stage, *topics):
    return frames_of(*(message for topic in topics for message in stage.wire.written[topic]))


@pytest.fixture(scope="module", params=ROBOTS)
def driven(request, tmp_path_factory):
    """A robot that has moved, and has published everything in its present state."""
    stage = Stage(tmp_path_factory.mktemp("driven"), {"R2": (request.param, 0.0, 0.0, 0.3)})
    stage.wire.command("/cmd_vel", 0.2, 0.2)
    stage.run(0.3)
    stage.simulation.robots[0].publish(0)
    return stage


def test_the_description_of_each_robot_is_valid_and_its_links_are_the_frames(driven):
    stage = driven
    text, model = stage.last("/robot_description").data, stage.world.model
    found, root = parsed(text), xml.fromstring(text)
    frames = transforms(stage, "/tf", "/tf_static")
    links = [link.get("name") for link in root.iter("link")]
    assert len(links) == len(set(links)) == len(root.findall("joint")) + 1
    assert {link for link in links if root.find(f"link[@name='{link}']/visual")} >= {"base_link"}
    # Frames in tf are those of the description at the angles of the joints.
    data, names = mujoco.MjData(found), [found.joint(j).name for j in range(found.njnt)]
    data.qpos[:] = [stage.world.data.qpos[model.joint(f"R2/{name}").qposadr[0]] for name in names]
    mujoco.mj_kinematics(found, data)
    footprint = found.body("base_footprint").id if "base_footprint" in links else 0
    for link in links:
        place, turn, _ = frames.pose("base_footprint", link)
        at = data.body(link).xpos - data.body(footprint).xpos
        assert np.allclose(place, at, atol=1e-6), link
        assert abs(np.dot(turn, data.body(link).xquat)) == pytest.approx(1.0)
    frames.pose("odom" if "/odom" in stage.wire.written else "base_footprint", "base_link")
    # Each joint is where the physics has it.
    stage.world.update_poses()
    true, base = stage.world.data, data.body("base_link").xpos
    for name in names:
        joint = model.joint(f"R2/{name}").id
        there = true.body("R2/base").xmat.reshape(3, 3).T @ (true.xanchor[joint] - true.body("R2/base").xpos)
        assert np.allclose(data.xanchor[found.joint(name).id] - base, there, atol=1e-6), name
    joints = stage.wire.written.get("/joint_states")
    assert not joints or set(joints[-1].name) <= set(names)
    # The hull collides, with the size that the world gives it.
    hull = stage.world.robots["R2"].hull
    sizes = {tuple(np.round(2.0 * model.geom_aabb[geom][3:], 6)) for geom in hull}
    boxes = {tuple(np.round(2.0 * found.geom_aabb[geom][3:], 6)) for geom in range(found.ngeom)}
    assert sizes <= boxes


def test_ranges_and_their_frames_are_those_of_the_sensors(driven):
    frames, sensors = transforms(driven, "/tf", "/tf_static"), driven.simulation.simulated.sensors["R2"].values()
    for sensor in (each for each in sensors if isinstance(each, (Lidar, RangeCone))):
        if isinstance(sensor, Lidar):
            fan, topics = (
                sensor.fan(),
                [topic for topic in ("/scan", f"/scan/{sensor.name}") if topic in driven.wire.qos],
            )
            keys, span = {"type": SCAN, "rays": fan.rays}, fan.step * (fan.rays - 1)
            places = [(fan.x, fan.y, fan.yaw + 0.5 * span, 0.0)]
        else:
            keys, span, topics = {"type": RANGE}, 0.0, [f"/range/{site}" for site in sensor.sites]
            places = [(beam.x, beam.y, beam.yaw, beam.elevation) for beam in sensor.beams()]
        messages = [driven.last(topic) for topic in topics]
        take = Ros2SensorParameters(topic="t", span=span, **keys).make_take(TYPES)
        if not sensor.noise:
            assert [value for m in messages for value in take(m)] == pytest.approx(list(sensor.read().values), abs=1e-6)
        for message, (x, y, yaw, up) in zip(messages, places, strict=True):
            place, turn, _ = frames.pose("base_link", message.header.frame_id)
            assert place[:2] == pytest.approx((x, y), abs=1e-6)
            ahead = Rotation.from_quat(turn, scalar_first=True).apply([1.0, 0.0, 0.0])
            level = math.cos(up)
            assert ahead == pytest.approx([level * math.cos(yaw), level * math.sin(yaw), math.sin(up)], abs=1e-6)
            limits = ("range_min", "range_max") if isinstance(sensor, Lidar) else ("min_range", "max_range")
            assert [getattr(message, name) for name in limits] == pytest.approx(sensor.range)
            if isinstance(sensor, RangeCone):
                assert message.field_of_view == pytest.approx(2.0 * sensor.half_angle)


def test_each_measured_value_has_a_variance_and_the_unmeasured_have_a_huge_one(driven):
    stage = driven
    sensors = list(stage.simulation.simulated.sensors["R2"].values())

    def of(kind):
        return [sensor for sensor in sensors if isinstance(sensor, kind)]

    for gyro in of(Gyro):
        imu = stage.last("/imu")
        covariance = np.reshape(imu.angular_velocity_covariance, (3, 3))
        noise = math.hypot(gyro.noise, gyro.bias_noise)
        assert np.diag(covariance) == pytest.approx([UNMEASURED, UNMEASURED, noise**2])
        assert imu.orientation_covariance[0] == imu.linear_acceleration_covariance[0] == -1.0
    if odometry := stage.wire.written.get("/odom"):
        pose, twist = (np.reshape(part.covariance, (6, 6)) for part in (odometry[-1].pose, odometry[-1].twist))
        for covariance in (pose, twist):
            assert np.allclose(covariance, covariance.T)
            assert np.linalg.eigvalsh(covariance)[0] > 0.0
        ideal = [each.noise for each in of((Position, Orientation))] == [0.0, 0.0]
        measured = [ideal] * 2 + [True] * 2
        assert [pose[i, i] < UNMEASURED for i in (2, 3, 0, 5)] == measured
        assert [twist[i, i] < UNMEASURED for i in (2, 3, 0, 5)] == [ideal, False, True, True]
    if fixes := stage.wire.written.get("/pose"):
        (position,), (orientation,) = of(Position), of(Orientation)
        noise = [position.noise**2] * 3 + [UNMEASURED, UNMEASURED, orientation.noise**2]
        assert np.diag(np.reshape(fixes[-1].pose.covariance, (6, 6))) == pytest.approx(noise)


class Encoders(WheelSpeed):
    """Encoders of a robot that drives straight ahead at 0.5 m/s, with noise; one reading each 50 ms."""

    def __init__(self, real, noise, rng):
        super().__init__(motors=real.motors, wheel_radius=real.wheel_radius, signs=real.signs)
        self.noise, self._rng, self._t = noise, rng, 0.0

    def read(self):
        self._t += 0.05
        return Reading(self._t, self._rng.normal(0.5, self.noise, len(self.motors)).tolist())


def test_the_covariance_of_wheel_odometry_is_that_of_its_errors(project):
    stage = Stage(project, {"R2": ("jackal", -1.5, -1.5, 0.0)})
    spec, sensors = stage.simulation.simulated.robots["R2"], stage.simulation.simulated.sensors["R2"]
    real, rng, ends = sensors["encoders"], np.random.default_rng(1), []
    for _ in range(200):
        odometry = WheelOdometry(Encoders(real, 0.1, rng), spec.locomotion, real.motors, 0.1)
        for _ in range(20):
            motion = odometry()
        ends.append((motion.pose.x, motion.pose.y, motion.pose.yaw))
    declared, found = np.reshape(motion.pose_covariance, (6, 6))[PARTS], np.cov(np.array(ends).T)
    assert np.diag(declared) == pytest.approx(np.diag(found), rel=0.35)
    assert declared[1, 2] == pytest.approx(found[1, 2], rel=0.35)


@pytest.mark.parametrize("options", [FrameOptions(), FrameOptions(map_to_odom=False, odom_to_base=False)])
def test_the_transforms_of_a_localiser_and_of_a_filter_can_be_left_to_them(project, options):
    stage = Stage(project, {"R1": ("jackal", 0.0, 0.0, 0.0)}, frames=options)
    stage.run(0.1)
    sent = [t for topic in ("/tf", "/tf_static") for m in stage.wire.written[topic] for t in m.transforms]
    parents = {each.child_frame_id: each.header.frame_id for each in sent}
    assert parents.get("odom") == ("map" if options.map_to_odom else None)
    assert parents.get("base_footprint") == ("odom" if options.odom_to_base else None)
    assert (parents["base_link"], parents["lidar"]) == ("base_footprint", "base_link")
    assert stage.last("/odom").header.frame_id == "odom"


def test_each_robot_of_a_team_has_its_own_transforms_on_request(project):
    team = {"R1": ("jackal", -1.5, -1.0, 0.0), "R2": ("summit_xl_localised", 1.0, 1.0, 0.0)}
    stage = Stage(project, team, namespace="team", frames=FrameOptions(per_namespace=True))
    stage.run(0.1)
    assert not {"/tf", "/tf_static"} & set(stage.wire.written)
    assert stage.wire.qos["/team/r1/tf_static"].durability == "transient_local"
    for robot in ("r1", "r2"):
        frames = transforms(stage, f"/team/{robot}/tf", f"/team/{robot}/tf_static")
        odom, scan = stage.last(f"/team/{robot}/odom"), f"/team/{robot}/scan"
        assert (odom.header.frame_id, odom.child_frame_id) == ("odom", "base_link")
        place, turn, _ = frames.pose("odom", "base_link")
        at = pose_of(odom.pose.pose.position, odom.pose.pose.orientation)
        assert Pose3.from_quaternion(place, turn) == pytest.approx(at, abs=0.02)
        if scan in stage.wire.written:
            frames.pose("map", stage.last(scan).header.frame_id)
        links = {link.get("name") for link in xml.fromstring(stage.last(f"/team/{robot}/robot_description").data)}
        assert {"base_footprint", "base_link"} <= links
    assert "/clock" in stage.wire.written
