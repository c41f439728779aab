# /// script
# requires-python = ">=3.11"
# dependencies = ["rocs_bt"]
# ///
"""Tick a behaviour tree without a robot: `rocs_bt.trees` needs no mission, no world and no simulation.

The tree of a vending machine is written in XML, which Groot2 can open. Its action node is a class with a port. The
clock is simulated, so brewing takes no time.

Output:

    serve
    Sequence
    ├─ Fallback
    │  ├─ ScriptCondition
    │  │      code = coins >= 2
    │  └─ ForceFailure
    │     └─ Say
    │            text = two coins, please
    ├─ brew  [Sleep]
    │      msec = 60000
    ├─ Say
    │      text = {drink}   (given: a cup of tea)
    └─ Script
           code = coins = coins - 2
      machine: two coins, please
    0 s: FAILURE
      machine: a cup of tea
    60 s: SUCCESS, 0 coins left
"""

from typing import Annotated

from rocs_bt import SimulatedClock
from rocs_bt.trees import BUILTIN, SUCCESS, Instant, Outcome, Tree, examine, load_xml
from rocs_bt.trees.draw import picture_of, text

XML = """
<root BTCPP_format="4" main_tree_to_execute="serve">
  <BehaviorTree ID="serve">
    <Sequence>
      <Fallback>
        <ScriptCondition code="coins &gt;= 2"/>
        <ForceFailure> <Say text="two coins, please"/> </ForceFailure>
      </Fallback>
      <Sleep name="brew" msec="60000"/>
      <Say text="{drink}"/>
      <Script code="coins = coins - 2"/>
    </Sequence>
  </BehaviorTree>
</root>
"""


class Say(Instant):
    """Prints a text."""

    text: Annotated[str, "text to print"]

    def update(self) -> Outcome:
        print(f"  machine: {self.text}")
        return SUCCESS


clock = SimulatedClock(step=1.0)
tree = Tree(load_xml(XML, BUILTIN.with_([Say])), clock=clock)
tree.board["coins"], tree.board["drink"] = 1, "a cup of tea"
print(text(picture_of(tree, "serve")))
for fault in examine(tree):
    print(fault)

print(f"{clock.now():.0f} s: {tree.tick().name}")
tree.board["coins"] = 2
while (outcome := tree.tick()).name == "RUNNING":
    clock.advance()
print(f"{clock.now():.0f} s: {outcome.name}, {tree.board['coins']} coins left")
