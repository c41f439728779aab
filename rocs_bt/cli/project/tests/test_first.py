"""The rover arrives. The fixture `run_scenario` comes with rocs_bt."""


def test_the_rover_patrols_and_hits_nothing(run_scenario):
    rover = run_scenario("first", seed=1).summary.agents["R1"]
    assert rover.outcome == "success"
    assert rover.collisions == 0
