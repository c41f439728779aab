"""Message types: defaults, CDR, definitions of users' own types."""

from __future__ import annotations

import numpy as np
import pytest
from mcap_ros2._dynamic import generate_dynamic

from rocs_bt.base.errors import DeviceError, InputError
from rocs_bt.ros2.messages.type_store import DISTROS, TypeStore

TYPES = TypeStore()


@pytest.mark.parametrize("name", sorted(TYPES.store.types))
def test_a_default_message_of_every_type_survives_cdr_and_is_read_by_an_independent_reader(name):
    data = TYPES.serialize(TYPES.make(name))
    again = TYPES.deserialize(data, name)
    assert TYPES.serialize(again) == data
    text = TYPES.store.generate_msgdef(name, ros_version=2)[0]
    decode = generate_dynamic(name, text)[name]
    message = decode(data)
    assert set(TYPES.fields(name)) <= set(message.__slots__) | {"structure_needs_at_least_one_member"}


@pytest.mark.parametrize("distro", DISTROS)
def test_every_distribution_has_the_types_of_the_short_forms(distro):
    from rocs_bt.ros2.devices.parameters import ACTUATOR_TYPES
    from rocs_bt.ros2.messages.message_types import MESSAGES

    types = TypeStore(distro)
    for name in (*MESSAGES, *ACTUATOR_TYPES):
        types.deserialize(types.serialize(types.make(name)), name)


def test_values_of_nested_messages_and_arrays():
    scan = TYPES.make("sensor_msgs/msg/LaserScan", header={"frame_id": "laser"}, ranges=[1.0, 2.0])
    assert scan.header.frame_id == "laser"
    assert scan.ranges.dtype == np.float32
    assert list(TYPES.make("geometry_msgs/msg/PoseWithCovariance").covariance) == [0.0] * 36
    joints = TYPES.make("sensor_msgs/msg/JointState", name=["a"], position=[0.5])
    assert TYPES.deserialize(TYPES.serialize(joints), "sensor_msgs/msg/JointState").name == ["a"]


def test_unknown_names_are_told_with_the_known_ones():
    with pytest.raises(InputError, match=r"no message type is named 'sensor_msgs/msg/LaserScn'.*Did you mean"):
        TYPES.make("sensor_msgs/msg/LaserScn")
    with pytest.raises(InputError, match=r"no field is named 'range'.*Did you mean 'ranges'"):
        TYPES.make("sensor_msgs/msg/LaserScan", range=[1.0])
    with pytest.raises(InputError, match=r"no distribution of ROS 2 is named 'jazy'.*Did you mean 'jazzy'"):
        TypeStore("jazy")


def test_a_type_of_the_user_is_found_with_the_types_of_its_fields():
    texts = {"my_msgs/msg/Arm": "my_msgs/Joint[] joints\nstd_msgs/Header header", "my_msgs/msg/Joint": "float64 angle"}
    types = TypeStore("jazzy", texts.get)
    arm = types.make("my_msgs/msg/Arm", joints=[{"angle": 0.5}])
    assert types.deserialize(types.serialize(arm), "my_msgs/msg/Arm").joints[0].angle == 0.5
    with pytest.raises(InputError, match=r"no message type is named 'my_msgs/msg/Leg'"):
        types.make("my_msgs/msg/Leg")
    with pytest.raises(InputError, match="the definition of 'my_msgs/msg/Bad' is faulty"):
        TypeStore("jazzy", {"my_msgs/msg/Bad": "float64 3 angle"}.get).message("my_msgs/msg/Bad")


@pytest.mark.parametrize("size", [0, 3, 4, 17, 100])
def test_truncated_data_is_a_fault_of_the_device(size):
    data = TYPES.serialize(TYPES.make("sensor_msgs/msg/LaserScan", ranges=[1.0] * 40))
    with pytest.raises(DeviceError, match="bytes are no sensor_msgs/msg/LaserScan"):
        TYPES.deserialize(data[:size], "sensor_msgs/msg/LaserScan")
