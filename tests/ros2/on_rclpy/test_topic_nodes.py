"""RosPublish and RosSubscribe through rclpy."""

import pytest

from ..topic_cases import CASES


@pytest.mark.parametrize("case", CASES)
def test_topics(servers, at_work, case):
    case("rclpy", servers, at_work)
