"""Static checks of a tree before it is ticked."""

from .blocking import blocking_faults
from .examine import examine, initial_value, node_faults
from .flow import Flow, Use, flow_of

__all__ = ["Flow", "Use", "blocking_faults", "examine", "flow_of", "initial_value", "node_faults"]
