"""Which keys a Nav2 mission needs from outside: those of its main tree that are read before they are written."""

import pytest

from rocs_bt.plan import mission_parameters, xml_mission

NAV = '<BehaviorTree ID="Nav"><ComputePathToPose goal="{goal}" path="{path}"/></BehaviorTree>'


@pytest.mark.parametrize("dialect", ["nav2", "nav2_servers"])
@pytest.mark.parametrize(
    ("body", "needed"),
    [
        ('<ComputePathToPose goal="{goal}" path="{path}"/>', ["goal"]),
        ('<Sequence><ComputePathToPose goal="{ goal }" path="{path}"/></Sequence>', []),  # the key ' goal '
        ('<ComputePathToPose goal="{=}" path="{path}"/>', ["goal"]),
        ('<ComputePathToPose goal="{@goal}" path="{path}"/>', ["goal"]),
        ('<SubTree ID="Nav" goal="{dock}"/>', []),
        ('<SubTree ID="Nav" goal="dock"/>', []),
        ('<SubTree ID="Nav"/>', []),
        ('<SubTree ID="Nav" goal="{goal}"/>', ["goal"]),
        ('<SubTree ID="Nav" goal="{=}"/>', ["goal"]),
        ('<SubTree ID="Nav" _autoremap="true"/>', ["goal"]),
        ('<SubTree ID="Nav" _autoremap="true" goal="dock"/>', []),
        ('<SubTree ID="Nav" goal="{goals}"/>', ["goals"]),
        ('<Sequence><Script code="goal := \'dock\'"/><SubTree ID="Nav" goal="{goal}"/></Sequence>', []),
        ('<Sequence><SubTree ID="Nav" goal="{goal}"/><Script code="goal := \'dock\'"/></Sequence>', ["goal"]),
        ('<Sequence><SetBlackboard value="dock" output_key="goal"/><SubTree ID="Nav" goal="{goal}"/></Sequence>', []),
        ('<RemovePassedGoals input_goals="{goals}" output_goals="{goals}"/>', ["goals"]),
    ],
)
def test_needed_keys_are_those_of_the_main_tree(body, needed, dialect):
    text = f'<root BTCPP_format="4" main_tree_to_execute="M"><BehaviorTree ID="M">{body}</BehaviorTree>{NAV}</root>'
    parameters = mission_parameters(xml_mission(text, dialect=dialect))
    assert sorted(name for name, parameter in parameters.items() if parameter.required) == needed
