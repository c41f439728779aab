"""The vocabulary of the node `Warmer`, in missions of every dialect; the node itself is loaded when a mission is."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from rocs_bt.interfaces.vocabulary import Vocabulary


def _nodes() -> Sequence[type[Any]]:
    from rocs_bt_thermometer.warmer import Warmer

    return [Warmer]


VOCABULARY = Vocabulary(anywhere=_nodes)
