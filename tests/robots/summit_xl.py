"""Modules of the SUMMIT-XL's folder, loaded as the catalog loads them."""

from rocs_bt.catalog import Catalog
from rocs_bt.python_content import load_module

FOLDER = Catalog().find("robot", "summit_xl").path.parent

surround_monitor = load_module(FOLDER / "surround_monitor.py")
edges, encounter, free_ground, gaps = (
    load_module(FOLDER / f"{name}.py") for name in ("edges", "encounter", "free_ground", "gaps")
)
