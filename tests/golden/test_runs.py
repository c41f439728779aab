"""The shipped scenarios run as they ran: bit for bit on the kind of machine that made the golden file."""

import pytest

from rocs_bt.catalog import Catalog

from . import runs

CATALOG = Catalog()
QUICK = (1,)  # the other seeds run in `make soak`
SHIPPED = runs.shipped(CATALOG)


def test_golden_runs_are_those_of_shipped_scenarios():
    """A kind of machine may lack scenarios whose robots have changed since; playing them there adds them."""
    wanted = {f"{name} {seed}" for name in SHIPPED for seed in runs.SEEDS}
    for golden in runs.stored():
        assert set(golden["runs"]) <= wanted
    assert {name.split()[0] for golden in runs.stored() for name in golden["runs"]} >= {"exp1", "exp2", "exp3"}


@pytest.mark.parametrize(
    "seed", [*QUICK, *(pytest.param(s, marks=pytest.mark.soak) for s in runs.SEEDS if s not in QUICK)]
)
@pytest.mark.parametrize("scenario", SHIPPED)
def test_a_shipped_scenario_runs_as_it_ran(scenario, seed):
    golden = runs.of_this_machine(runs.stored())
    if f"{scenario} {seed}" not in golden:
        pytest.skip(f"no golden runs of this scenario were computed by this kind of machine: {runs.machine()}")
    assert runs.play(scenario, seed, CATALOG) == golden[f"{scenario} {seed}"]
