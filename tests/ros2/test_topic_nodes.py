"""RosPublish and RosSubscribe through DDS without ROS, where services and actions are refused."""

import pytest

from rocs_bt.base.errors import InputError

from .topic_cases import CASES


@pytest.mark.parametrize("case", CASES)
def test_topics(servers, at_work, case):
    case("dds", servers, at_work)


@pytest.mark.parametrize(
    "line",
    [
        '<RosService service="lamp" type="std_srvs/srv/SetBool"/>',
        '<RosAction action="fibonacci" type="test_msgs/action/Fibonacci"/>',
        '<RosActionServer action="a" type="test_msgs/action/Fibonacci"><AlwaysSuccess/></RosActionServer>',
    ],
)
def test_without_rclpy_services_and_actions_are_refused_before_the_run(ros_environment, at_work, line):
    with pytest.raises(InputError) as caught:
        at_work(line, "dds")
    (fault,) = caught.value.faults
    assert "need rclpy" in fault.message
    assert "the vendors of DDS send the headers of requests differently" in fault.message
    assert 'transport = "rclpy"' in fault.hint
    assert fault.line == 1
