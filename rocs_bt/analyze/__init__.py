"""A of MAPE-K: analysers find out whether the world changed, update Knowledge and tell Plan (paper, 4.2).

Imported by `agent` and the layers above; the other blocks never import it.
"""

from .analyze import Analyze
from .localise import Localise
from .pass_messages import PassMessages
from .pass_orientation import PassOrientation
from .pass_position import PassPosition
from .pass_range import PassRange
from .peer_analyze import PeerAnalyze
from .table import ANALYZERS

__all__ = [
    "ANALYZERS",
    "Analyze",
    "Localise",
    "PassMessages",
    "PassOrientation",
    "PassPosition",
    "PassRange",
    "PeerAnalyze",
]
