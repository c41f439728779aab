"""Test of the scenario `first`. The fixture `run_scenario` is provided by rocs_bt."""


def test_the_rover_reaches_its_goals_without_collision(run_scenario):
    rover = run_scenario("first", seed=1).summary.agents["R1"]
    assert rover.outcome == "success"
    assert rover.collisions == 0
