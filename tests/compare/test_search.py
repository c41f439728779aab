"""Search for trouble: the smallest scene, the same each time, fair to whoever fails in it."""

from __future__ import annotations

import math
from concurrent.futures import Executor, Future
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rocs_bt import Pose2
from rocs_bt.base.errors import InputError
from rocs_bt.catalog import CachingCatalog, Catalog
from rocs_bt.compare import Block, EpisodeStore, Floor, Post, Scene, goal_scenario, load_family
from rocs_bt.compare.record import EpisodeRecord
from rocs_bt.compare.replay import replay_episode, scene_by_name
from rocs_bt.control.footprint import Footprint
from rocs_bt.declare import replaced
from rocs_bt.search.command import keep
from rocs_bt.search.draft import Draft
from rocs_bt.search.player import Player
from rocs_bt.search.run_search import SearchOptions, search
from rocs_bt.search.shrink import Fairness, Shrinking
from rocs_bt.search.space import SearchSpace

BODY = Footprint(0.5, 0.4)
FAMILY = '''"""Posts here and there, and one in the way."""

from rocs_bt import Pose2
from rocs_bt.compare import Family, Floor, Post, Scene, goal_scenario
from rocs_bt.base.units import PositiveMetres


class Posts(Family):
    """Posts here and there, and one in the way."""

    robot: str = "pioneer_p3dx"
    posts: int = 4
    size: PositiveMetres = 0.2
    blocked: int = 1

    def scene(self, index):
        rng = self.rng(index)
        floor = Floor((-3.0, -3.0), (3.0, 3.0))
        floor.obstacles += [Post(f"p{i}", x, 2.5, 0.1) for i, x in enumerate(rng.uniform(-2, 2, self.posts).tolist())]
        if self.blocked:
            floor.obstacles.append(Post("middle", float(rng.uniform(0.1, 0.2)), 0.03, self.size))
        name = self.scene_name(index)
        scenario = goal_scenario(
            self, name, "Posts.", Pose2(-1.0, 0.0, 0.0), (1.1, 0.0), tolerance=0.2, duration=3.0
        )
        return Scene(scenario, floor)
'''


class Here(Executor):
    """Plays everything at once, in this process, and notes what."""

    workers = 1

    def __init__(self, most=math.inf):
        self.played, self._most = [], most

    def submit(self, fn, /, *args, **kwargs):
        if len(self.played) == self._most:
            raise KeyboardInterrupt
        self.played.append(args[0].key)
        future: Future = Future()
        try:
            future.set_result(fn(*args, **kwargs))
        except Exception as error:  # noqa: BLE001 - as executors do
            future.set_exception(error)
        return future


@pytest.fixture
def yard(tmp_path):
    (tmp_path / "scenarios" / "families").mkdir(parents=True)
    (tmp_path / "scenarios" / "families" / "posts.py").write_text(FAMILY)
    return tmp_path


def sought(yard, planner="tree_no_reflexes", fixed=None, executor=None, store=None, **options):
    catalog = Catalog(yard)
    space = SearchSpace.of(load_family(catalog, "posts", fixed or {}), fixed or {}, {})
    who, wanted = catalog.load_planner(planner), SearchOptions(**options)
    return search(who, space, wanted, catalog=catalog, store=store, executor=executor or Here())


def scene_of(obstacles, start=(-2.0, 0.0), goal=(2.0, 0.0), actors=()):
    driver = load_family(Catalog(), "exp1_family")
    scenario = goal_scenario(driver, "made", "Made.", Pose2(*start, 0.1234), goal, tolerance=0.1, duration=5.0)
    return Scene(scenario, Floor((-4.0, -4.0), (4.0, 4.0), list(obstacles), list(actors)))


class OutcomeDecided(Player):
    """Plays nothing: fails where it is told to, and notes what was tried."""

    def __init__(self, fails, budget=10_000):
        super().__init__(None, None, None, None, budget, 0.0, lambda done: None)
        self._judge, self.tried = fails, []

    def _play(self, drafts, fails, skip_invalid):
        found = []
        for draft in drafts:
            self.tried.append(draft)
            found.append(episode("collision" if self._judge(draft) else "success"))
            if fails(found[-1]):
                break
        return found


def episode(outcome):
    track = np.array([[0.0, 0.0], [0.5, 0.0]], np.float32).tobytes()
    return EpisodeRecord(key="", planner="p", family="f", scene="s", seed=1, outcome=outcome, track=track)


def shrunk(draft, fails, budget=10_000):
    player = OutcomeDecided(fails, budget)
    shrinking = Shrinking(player, draft, episode("collision"), BODY)
    shrinking.run()
    return shrinking.draft, player


NUMBERS = st.floats(-3.5, 3.5).map(lambda v: round(v, 3))


@st.composite
def fields(draw):
    """Things around a straight way that is free, and some of them that are to blame."""
    obstacles = []
    for i in range(draw(st.integers(0, 12))):
        x, side, away = draw(NUMBERS), draw(st.sampled_from([-1.0, 1.0])), draw(st.floats(0.8, 3.0))
        if draw(st.booleans()):
            obstacles.append(Post(f"t{i}", x, side * away, draw(st.floats(0.05, 0.2))))
        else:
            yaw = draw(st.floats(0.0, math.pi))
            obstacles.append(Block(f"t{i}", x, side * away, draw(st.floats(0.1, 0.3)), draw(st.floats(0.1, 0.3)), yaw))
    names = [obstacle.name for obstacle in obstacles]
    return obstacles, set(draw(st.lists(st.sampled_from(names), unique=True, max_size=3))) if names else set()


@settings(max_examples=10, deadline=None)
@given(fields())
def test_what_is_left_is_exactly_what_is_needed(field):
    obstacles, needed = field
    draft = Draft.of(scene_of(obstacles), "small", "Small.")
    left, player = shrunk(draft, lambda d: needed <= set(d.obstacles))
    assert set(left.obstacles) == needed
    assert math.dist(left.start, left.goal) == pytest.approx(1.0, abs=0.35)  # as near as is fair
    assert Fairness.of(draft, BODY).holds(left)
    assert len(set(player.tried)) == len(player.tried) == player.count


def test_things_that_only_matter_together_are_told_from_all_others():
    obstacles = [Post(f"t{i}", -3.0 + 0.2 * i, 2.0, 0.05) for i in range(30)]
    draft = Draft.of(scene_of(obstacles), "small", "Small.")
    left, player = shrunk(draft, lambda d: "t3" in d.obstacles and ("t29" in d.obstacles or len(d.obstacles) > 20))
    assert set(left.obstacles) == {"t3", "t29"}
    assert player.count < 120


def test_numbers_become_as_simple_as_the_failure_allows():
    draft = Draft.of(scene_of([Post("post", 0.4321, 1.2345, 0.1234)]), "small", "Small.")
    left, _ = shrunk(draft, lambda d: "post" in d.obstacles and abs(d.obstacles["post"][0] - 0.4321) < 0.05)
    (post,) = left.floor.obstacles
    assert (post.x, post.y, post.radius) == (0.4, 1.2, 0.1)  # 0.4 is the coarsest; a post is rounded as one
    assert left.scene.scenario["agent"][0]["yaw"] == "0 deg"


def test_the_budget_bounds_what_is_played_and_the_smallest_so_far_is_kept():
    draft = Draft.of(scene_of([Post(f"t{i}", -3.0 + 0.4 * i, 2.0, 0.05) for i in range(16)]), "small", "Small.")
    left, player = shrunk(draft, lambda d: "t5" in d.obstacles, budget=3)
    assert player.count == len(player.tried) == 3
    assert 1 < len(left.obstacles) < 16


def test_nobody_ends_in_a_thing_and_no_scripted_actor_begins_on_the_start():
    post, walker = Post("post", 1.0, 0.7, 0.3), Post("walker", 0.5, -1.2, 0.25)
    actor = {"name": "walker", "script": "slide", "x": "0.5 m", "y": "-1.2 m", "to_x": "0 m", "to_y": "0 m"}
    scene = scene_of([post], actors=[walker])
    draft = Draft.of(replace(scene, scenario=scene.scenario | {"actor": [actor]}), "small", "Small.")
    left, player = shrunk(draft, lambda d: len(d.obstacles) == 2)
    fair = Fairness.of(draft, BODY)
    for each in (left, *player.tried):
        grid = each.floor.grid(0.01)
        assert min(grid.clearances()[grid.cell_at(each.start)], grid.clearances()[grid.cell_at(each.goal)]) > 0.29
        assert math.dist(each.obstacles.get("walker", (9, 9)), each.start) >= fair.apart == 1.0
    inside = draft.between(draft.start, (1.0, 0.6))
    assert not fair.holds(inside)


@pytest.mark.parametrize("entry", Catalog().list("family"), ids=lambda entry: entry.name)
def test_every_familys_scene_can_be_taken_apart(entry, tmp_path):
    """A draft is an ordinary scenario, and so is what is left of it: the same as a value and as files."""
    scene = load_family(Catalog(), entry.name).scene(3)
    draft = Draft.of(scene, "small", "Small.")
    bare = draft.without(draft.obstacles).rounded(1.0, 90.0, [""])
    assert not bare.obstacles
    for i, each in enumerate((draft, draft.rounded(0.1, 15.0, ["", *draft.obstacles]), bare)):
        each.scene.write(tmp_path / str(i))
        catalogs = each.scene.added_to(CachingCatalog()), Catalog(tmp_path / str(i))
        made, read = (catalog.load_scenario("small") for catalog in catalogs)
        assert (made.name, made.agents[0].jitter) == ("small", Pose2(0.0, 0.0, 0.0))
        assert [agent.parameters for agent in made.agents] == [agent.parameters for agent in read.agents]
        assert catalogs[0].digest(made) == catalogs[1].digest(read)


def test_a_search_finds_the_post_in_the_way_and_leaves_nothing_else(yard):
    result = sought(yard, fixed={"blocked": 1})
    assert result.searched == 1
    assert (result.first.outcome, result.last.outcome, result.done) == ("collision", "collision", True)
    assert len(result.found.obstacles) > 1
    assert list(result.smallest.obstacles) == ["middle"]
    assert math.dist(result.smallest.start, result.smallest.goal) < 2.0
    scenario, test = keep(result.smallest, "tree_no_reflexes", yard)
    again = replay_episode("tree_no_reflexes", result.smallest.name, 1, Catalog(yard), yard / "out")
    assert again.summary.trajectory_hash == result.last.trajectory_hash
    assert again.summary.agents["R"].outcome == "collision"
    assert scene_by_name(scenario.stem, Catalog(yard)).name == scenario.stem
    compile(test.read_text(), str(test), "exec")


def test_the_same_seed_finds_the_same_scene_and_plays_nothing_twice_even_if_it_was_killed(yard):
    whole, again, before, after, other = Here(), Here(), Here(most=4), Here(), Here()
    wanted = {"budget": 5, "fixed": {"blocked": 1}}
    with EpisodeStore() as store:
        undisturbed = sought(yard, executor=whole, store=store, **wanted)
        assert sought(yard, executor=again, store=store, **wanted) == undisturbed
    assert again.played == []
    assert len(whole.played) == len(set(whole.played))
    with EpisodeStore() as store:
        with pytest.raises(KeyboardInterrupt):
            sought(yard, executor=before, store=store, **wanted)
        kept = store.count()
        assert sought(yard, executor=after, store=store, **wanted) == undisturbed
    assert len(after.played) <= len(whole.played) - kept
    assert sought(yard, executor=other, budget=1, seed=2).sampled != undisturbed.sampled


def test_only_the_failure_that_is_sought_counts(yard):
    assert sought(yard, fixed={"blocked": 1}, failures=("stuck",), budget=3).found is None
    result = sought(yard, planner="none", fixed={"blocked": 0, "posts": 3}, budget=9)
    assert result.first.outcome == "timeout"  # it stands from the beginning to the end
    assert not result.smallest.obstacles
    assert math.dist(result.smallest.start, result.smallest.goal) > 0.95


def test_numbers_are_drawn_from_half_to_twice_and_flags_are_flags(yard):
    family = load_family(Catalog(yard), "posts", {"posts": 3})
    space = SearchSpace.of(family, {"posts": 3}, {"size": "0.1 m..20 cm"})
    assert space.ranges == {"size": (0.1, 0.2), "blocked": (0, 1)}
    assert SearchSpace.of(family, {}, {}).ranges == {"posts": (1, 6), "size": (0.1, 0.4), "blocked": (0, 1)}
    rng = np.random.default_rng(1)
    drawn = [space.sample(rng) for _ in range(40)]
    assert {d.parameters["blocked"] for d in drawn} == {0, 1}
    assert all(0.1 <= d.parameters["size"] <= 0.2 for d in drawn)
    assert len({d.index for d in drawn}) == 40
    assert drawn[0].scene == replaced(family, **drawn[0].parameters).scene(drawn[0].index)


@pytest.mark.parametrize(
    ("told", "fault"),
    [
        ({"size": "3"}, "'3' is not a range of size"),
        ({"size": "1..2"}, "needs a unit"),
        ({"size": "1 s..2 s"}, "must be in m"),
        ({"size": "-1 m..2 m"}, "size must be"),
        ({"size": "2 m..1 m"}, "bounds swapped"),
        ({"posts": "1.5..3"}, "a whole number"),
        ({"robot": "a..b"}, "no number is named 'robot'"),
    ],
)
def test_a_range_that_is_none_is_refused(yard, told, fault):
    with pytest.raises(InputError, match=fault):
        SearchSpace.of(load_family(Catalog(yard), "posts"), {}, told)
