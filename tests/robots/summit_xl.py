"""Modules of the SUMMIT-XL's folder, loaded as the catalog loads them."""

from rocs_bt.base.python_content import load_module
from rocs_bt.catalog import Catalog

FOLDER = Catalog().find("robot", "summit_xl").path.parent

surround_monitor = load_module(FOLDER / "surround_monitor.py")
edges, encounter, free_ground, gaps = (
    load_module(FOLDER / f"{name}.py") for name in ("edges", "encounter", "free_ground", "gaps")
)
