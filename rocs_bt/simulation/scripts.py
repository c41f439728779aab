"""Scripts of actors by name; a project has its own, in a Python file beside the scenario."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from typing import Any

from ..base.errors import Fault, InputError, UnknownName, located_at, unknown
from ..base.python_content import is_reference, running_class
from ..catalog import ActorSpec
from ..declare import keys_of, location_of
from .people import Leg, Polynomial, SocialForce
from .scripted_object import ScriptedObject
from .scripted_objects import Free, Slide, Swing
from .scripted_robots import RandomWalk, ScriptedRobot

FREE = "free"
"""Name of the script of objects that only physics moves."""

SCRIPTED_OBJECTS: Mapping[str, type[ScriptedObject]] = {
    "slide": Slide,
    FREE: Free,
    "swing": Swing,
    "polynomial": Polynomial,
    "social_force": SocialForce,
    "leg": Leg,
}

SCRIPTED_ROBOTS: Mapping[str, type[ScriptedRobot]] = {"random_walk": RandomWalk}


def object_script(actor: ActorSpec, load: Callable[[str], type]) -> ScriptedObject:
    """Script of an object, with the keys of its table, not yet bound.

    Args:
        actor: Table of the object in the scenario.
        load: Class of a script by `file.py:Class`.

    Raises:
        InputError: There is no such script, or its keys are wrong; lists every fault.
    """
    made: ScriptedObject = _script(actor, "object", SCRIPTED_OBJECTS, load, ScriptedObject)
    return made


def robot_script(actor: ActorSpec, load: Callable[[str], type]) -> ScriptedRobot:
    """Script of a robot; see `object_script`."""
    made: ScriptedRobot = _script(actor, "robot", SCRIPTED_ROBOTS, load, ScriptedRobot)
    return made


def _script(actor: ActorSpec, of: str, known: Mapping[str, type], load: Callable[[str], type], base: Any) -> Any:
    place = location_of(actor, "script")
    with located_at(place.file, place.line):
        cls = _class(actor.script, of, known, load, base)
    with running_class(cls):
        return actor.with_keys(cls)


def _class(name: str, of: str, known: Mapping[str, type], load: Callable[[str], type], base: Any) -> Any:
    if not is_reference(name) and name not in known:
        raise UnknownName(unknown(f"{of} script", name, known, then="Or name your own: 'file.py:Class'."))
    cls: Any = load(name) if is_reference(name) else known[name]
    if not issubclass(cls, base):
        hint = f"Write: class {cls.__name__}({base.__name__}), with {base.__name__} of rocs_bt.simulation."
        raise InputError(Fault(f"'{cls.__name__}' is no script of {'an' if of == 'object' else 'a'} {of}.", hint=hint))
    keys = keys_of(cls)
    if missing := ", ".join(sorted(cls.__abstractmethods__)):
        raise InputError(Fault(f"the script '{cls.__name__}' has no method {missing}."))
    if cls.__init__ is not base.__init__:
        raise InputError(Fault(f"the script '{cls.__name__}' has an __init__.", hint="Name it begin(self)."))
    if taken := inspect.signature(base.bind).parameters.keys() & keys:
        hint = "Give the key another name: a script has an attribute of this one."
        raise InputError(Fault(f"'{min(taken)}' of '{cls.__name__}' is no name of a key.", hint=hint))
    return cls
