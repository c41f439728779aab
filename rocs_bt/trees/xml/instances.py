"""A tree as BehaviorTree.CPP tells it to Groot2: one BehaviorTree for each use of a subtree, every node numbered."""

from __future__ import annotations

from py_trees.behaviour import Behaviour

from ..nodes import BUILTIN, SubTree, Tree
from ..nodes.port import ExactKey
from .element import Element
from .palette import model_of
from .text import element, to_text, value_text
from .write import Writer


def write_instances(tree: Tree, main: str) -> str:
    """A running tree as a document whose nodes have their `_uid`, and whose subtrees their `_fullpath`.

    Args:
        tree: The tree.
        main: The ID of its outermost tree.
    """
    return _Instances(tree).whole(main)


class _Instances(Writer):
    def __init__(self, tree: Tree) -> None:
        super().__init__(None)
        self._root = tree.root
        self._uids = {node.id: str(uid) for uid, node in enumerate(tree.nodes, 1)}
        self._paths = tree.paths()
        self._foreign: dict[str, Element] = {}

    def whole(self, main: str) -> str:
        body = self.tree(self._root)
        first = element("BehaviorTree", {"ID": main, "_fullpath": ""}, [body])
        classes = {**BUILTIN, **self.classes}
        models = [model_of(classes[tag]) for tag in sorted(classes) if classes[tag].kind != "SubTree"]
        models += [self._foreign[tag] for tag in sorted(self._foreign) if tag not in classes]
        trees = [self.trees[uid] for uid in sorted(self.trees, key=int)]
        return to_text(element("root", {"BTCPP_format": "4"}, [first, *trees, element("TreeNodesModel", {}, models)]))

    def subtree(self, node: SubTree, body: Element) -> Element:
        uid, path = self._uids[node.id], self._paths[node.id]
        self.trees[uid] = element("BehaviorTree", {"ID": node.tree, "_fullpath": path}, [body])
        own = {"ID": node.tree, "_fullpath": path, "_uid": uid} | ({"_autoremap": "true"} if node.autoremap else {})
        return element(
            "SubTree",
            own | {n: value_text(v) for n, v in node.remaps.items() if not isinstance(v, ExactKey)} | self.rest(node),
        )

    def node(self, node: Behaviour, below: list[Element]) -> Element:
        made = super().node(node, below)
        tag = made.attributes.get("ID", made.tag)
        kind = "Control" if len(below) > 1 else "Decorator" if below else "Action"
        model = self._foreign.setdefault(tag, element(getattr(node, "kind", kind), {"ID": tag}))
        known = {port.attributes["name"] for port in model.children}
        ports = [n for n in made.attributes if n not in ("ID", "name", *known) and not n.startswith("_")]
        model.children += [element("input_port", {"name": name}) for name in ports]
        given = {**made.attributes, "name": node.name, "_uid": self._uids[node.id]}
        made.attributes = {n: given.pop(n) for n in ("ID", "name", "_uid") if n in given} | given
        return made
