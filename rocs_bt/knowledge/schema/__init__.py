"""Schema of the knowledge graph, as data; the shipped one is in the TOML files of this folder.

A project extends it in files of `scenarios/schema/`, or in code:

    schema = SCHEMA.extended(
        kinds=[Kind("charger", {"power": Attribute(float, (FORCE * SPEED,))}, extends="place")],
        relations=[Relation("docks_at", ("robot",), ("charger",), single=True)],
    )
"""

from pathlib import Path

from .files import FORMAT, POSE, load_schema, schema_text
from .schema import Schema

__all__ = ["FORMAT", "POSE", "SCHEMA", "Schema", "load_schema", "schema_text"]

SCHEMA = load_schema(sorted(Path(__file__).parent.glob("*.toml")))
