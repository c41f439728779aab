"""Declared classes: their annotations are the keys of a table, the marks in them say which values are valid.

    class Push(Value):
        robot: Annotated[str, Names("robot", "no agent or robot", "The scenario")]
        at: Annotated[float, TIME, Bounds(0.0, 86400.0)]
        spread: Annotated[float, ANGLE, Bounds(0.0, math.pi)] = 0.0

A mark is an object of a module, not a lambda in the annotation: annotations are resolved when the class is first read.
"""

from __future__ import annotations

import functools
import inspect
import numbers
import re
import types
import typing
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import InitVar, dataclass, field, replace
from pathlib import Path
from typing import Any, ClassVar, Literal, NamedTuple, TypeVar, cast, dataclass_transform

from ..base.errors import Fault, InputError, did_you_mean
from ..base.raised import definition_of
from ..base.toml_table import Table
from ..base.units import FINITE, NONE, Bounds, Dimension, Quantity
from .marks import InUnit, Key, Keys, OneOf, Option, ReadBy, Registered, Rest, SetByPrograms, TableName, Valid
from .open import Open

MISSING = object()
"""Default of a field that must be given."""

_NO_DATACLASS = "Remove the decorator: the annotations declare the values, and the base class has the constructor."
_BOUNDED = "Write texts, or a number with bounds: Annotated[int, Bounds(1, 2)]."

M = TypeVar("M")
D = TypeVar("D", bound="Declared")

_WORDS: Mapping[Any, tuple[str, str]] = {
    str: ("a text", "texts"),
    bool: ("true or false", "flags"),
    int: ("a whole number", "whole numbers"),
    Path: ("a path", "paths"),
    object: ("a value", "values"),
    Callable: ("a function", "functions"),
}
_ENTRY = re.compile(r"^    (\w[\w, ]*): (.*(?:\n      .*)*)", re.MULTILINE)
_NO_KEYS = (ReadBy, Registered, Rest, SetByPrograms, TableName)
_KINDS: Mapping[Any, Any] = {float: numbers.Real, int: numbers.Integral, Path: (str, Path)}
_LISTS = (list, tuple, Sequence)
_PLAIN = (bool, int, float, str, Path, Any)


class Wrong(NamedTuple):
    """Fault of values that do not fit each other, of `Declared._check`.

    Attributes:
        key: Key at which the fault is reported; None for the table.
        message: One sentence: what was expected and what was found.
        hint: Advice.
        of: Object of the table with the key; None for the object that is checked.
    """

    key: str | None
    message: str
    hint: str = ""
    of: Declared | None = None


@dataclass(frozen=True)
class Field:
    """Declaration of one named value.

    Attributes:
        name: Name in Python.
        key: Key in a file.
        hint: Type of the value, or of each one of a list or table of values.
        marks: Marks of the annotation, the outermost last.
        parts: Fields of a list with a fixed number of values, such as `tuple[Metres, Radians]`, or of each of a list of
            these; the field of each value in a list of lists; else empty.
        default: Value without the key; `MISSING` if it must be given.
        many: `list` for `tuple[X, ...]` or `Sequence[X]`, `named` for `Mapping[str, X]`; else empty.
        owner: Class that declares the field.
        made: Type of lists that are read.
    """

    name: str
    key: str
    hint: Any
    marks: tuple[Any, ...]
    default: Any
    many: str
    owner: type
    parts: tuple[Field, ...] = ()
    made: type = tuple

    @property
    def required(self) -> bool:
        """Whether a value must be given."""
        return self.default is MISSING

    @functools.cached_property
    def dimension(self) -> Dimension | None:
        """Dimension of the numbers; None for other values."""
        part = self.parts[0] if self.parts else self
        return part.mark(Dimension) or NONE if part.hint is float else None

    @functools.cached_property
    def bounds(self) -> Bounds:
        """Valid numbers."""
        return self.mark(Bounds) or FINITE

    @functools.cached_property
    def is_plain(self) -> bool:
        """Whether a file can give the value in one key: a number, a text, a flag, or a list of these."""
        return bool(self.parts or self.options) or self.hint in (float, int, str, bool)

    @functools.cached_property
    def is_key(self) -> bool:
        """Whether the value is that of one key of the table."""
        keys = self.mark(Keys)
        return not (keys and keys.here) and not any(self.mark(kind) for kind in _NO_KEYS)

    @functools.cached_property
    def is_raw(self) -> bool:
        """Whether the value is a table that is not converted."""
        return self.hint is Open or typing.get_origin(self.hint) is Mapping

    @functools.cached_property
    def is_table(self) -> bool:
        """Whether the value is a table, or several."""
        nested = isinstance(self.hint, type) and issubclass(self.hint, Declared)
        return nested or self.is_raw or ((of := self.mark(Keys)) is not None and not of.here)

    @functools.cached_property
    def words(self) -> str:
        """Kind of the values, such as `a list of texts` or `a quantity [m]`."""
        if self.is_table:
            return {"list": "a list of tables", "named": "a table of tables", "": "a table"}[self.many]
        unit = "" if self.mark(InUnit) or self.hint is Quantity else f" [{self.mark(Dimension) or NONE}]"
        if self.hint is object and self.mark(Dimension) is not None:
            return f"a quantity{unit} or the name of one"
        if self.parts:
            return f"a list of {'lists' if self.many else f'{len(self.parts)} values'}"
        number = self.hint in (float, Quantity)
        one, more = (f"a quantity{unit}", f"quantities{unit}") if number else _words(self)
        return {"list": f"a list of {more}", "named": f"a table of {more}", "": one}[self.many]

    @functools.cached_property
    def options(self) -> tuple[str, ...]:
        """Valid texts; empty if there are others."""
        if (one_of := self.mark(OneOf)) is not None:
            return one_of.options
        return typing.get_args(self.hint) if typing.get_origin(self.hint) is Literal else ()

    @functools.cached_property
    def doc(self) -> str:
        """Description: a text in the annotation, else the entry of the name in the docstring of the class."""
        return self.mark(str) or docs_of(self.owner).get(self.name, "")

    def mark(self, kind: type[M]) -> M | None:
        """Mark of a class; the outermost of several, None if there is none."""
        return cast("M | None", self._by_class.get(kind))

    def parts_of(self, value: Collection[Any]) -> tuple[Field, ...]:
        """Fields of the values of a list with parts."""
        fixed = typing.get_origin(self.hint) is tuple and ... not in typing.get_args(self.hint)
        return self.parts if fixed else self.parts * len(value)

    def faults(self, value: Any, what: str) -> list[Fault]:
        """Faults of a value that a program gives, SI units.

        Args:
            value: The value.
            what: Name of the value in messages, such as `rays of lidar 'front'`.
        """
        if self.many == "named" and value is not None and not isinstance(value, Mapping):
            return [Fault(f"{what} must be a mapping, found {value!r:.80}.")]
        if self.many == "named":
            named = (self._faults_of_one(one, f"{name} of {what}") for name, one in (value or {}).items())
            return next(filter(None, named), [])
        if self.many != "list":
            return self._faults_of_one(value, what)
        if not _is_list(value):
            return [Fault(f"{what} must be a list, found {value!r:.80}.")]
        return next(filter(None, (self._faults_of_one(one, f"each of {what}") for one in value)), [])

    def _faults_of_one(self, value: Any, what: str) -> list[Fault]:
        if self.parts:
            if not _is_list(value):
                return [Fault(f"{what} must be a list, found {value!r:.80}.")]
            if len(value) != len(parts := self.parts_of(value)):
                return [Fault(f"{what} must have {len(parts)} values, found {len(value)}.")]
            return [fault for part, one in zip(parts, value, strict=True) for fault in part._faults_of_one(one, what)]
        kind: Any = _KINDS.get(self.hint, str if self.options else typing.get_origin(self.hint) or self.hint)
        unchecked = not isinstance(kind, (type, tuple))
        if unchecked or (value is None and not self.required and self.default is None):
            return []
        if not isinstance(value, kind) or (isinstance(value, bool) and self.hint in (float, int)):
            words = "a number" if self.hint is float else _words(self)[0]
            return [Fault(f"{what} must be {words}, found {value!r:.80}.")]
        if self.hint in (float, int) and not self.bounds.admit(value):
            unit = "" if self.dimension in (None, NONE) else f" {self.dimension}"
            wanted = self.bounds.broken(value, self.dimension or NONE)
            return [Fault(f"{what} must be {wanted}, found {value:g}{unit}.")]
        if self.options and value not in self.options:
            hint = did_you_mean(value, self.options, "Valid values:")
            return [Fault(f"invalid value '{value}' for {what}.", hint=hint)]
        valid = (mark for mark in self.marks if isinstance(mark, Valid) and not mark.test(value))
        return [Fault(f"{value!r:.80} is not {mark.what}.", hint=mark.hint) for mark in valid]

    @functools.cached_property
    def _by_class(self) -> dict[Any, Any]:
        return {type(mark): mark for mark in self.marks}

    @classmethod
    def annotated(cls, name: str, hint: Any, default: Any, owner: type) -> Field:
        """Field of an annotation such as `Annotated[tuple[Metres, ...], Key("at")]`."""
        marks: tuple[Any, ...] = ()
        made: type = tuple
        many, origin = "", typing.get_origin(hint)
        while origin is not None and origin is not Literal:
            args = typing.get_args(hint)
            if origin is typing.Annotated:
                marks, hint = (*hint.__metadata__, *marks), args[0]
            elif origin in (typing.Union, types.UnionType):
                others = [arg for arg in args if arg is not type(None)]
                hint = others[0] if len(others) == 1 else object
            elif many:
                break
            elif origin in _LISTS and (origin is not tuple or args[1:] == (...,)):
                many, hint, made = "list", args[0], list if origin is list else tuple
            elif origin is Mapping and args[1] is not Any:
                many, hint = "named", args[1]
            else:
                break
            origin = typing.get_origin(hint)
        if origin is Literal and not all(isinstance(each, str) for each in typing.get_args(hint)):
            raise class_error(owner, f"'{name}' of '{owner.__name__}' has values that are no texts.", _BOUNDED)
        if not _is_checkable(typing.get_origin(hint) or hint):
            kind = getattr(hint, "__name__", hint)
            message = f"'{name}' of '{owner.__name__}' has the type {kind}, for which no value can be checked."
            raise class_error(owner, message, "Write a type, or Any; or decorate a Protocol with @runtime_checkable.")
        within = typing.get_args(hint) if origin in _LISTS and not any(isinstance(mark, Keys) for mark in marks) else ()
        outer = tuple(mark for mark in marks if isinstance(mark, (Dimension, Bounds)))
        inner = (cls.annotated(name, part, MISSING, owner) for part in within if part is not ...)
        parts = tuple(replace(part, marks=(*outer, *part.marks)) for part in inner)
        key = next((mark.name for mark in marks if isinstance(mark, Key)), name)
        return cls(name, key, object if hint is Any else hint, marks, default, many, owner, parts, made)


def _words(of: Field) -> tuple[str, str]:
    """Kind of a value, and of several."""
    kind = typing.get_origin(of.hint) or of.hint
    name = getattr(kind, "__name__", "value")
    others = f"an object of the type {name}", f"objects of the type {name}"
    return _WORDS[str] if of.options else _WORDS.get(kind, others)


def class_error(cls: type, message: str, hint: str) -> InputError:
    """Error about a class, at its definition."""
    fault, place = Fault(message, hint=hint), definition_of(cls)
    return InputError(fault if place is None else fault.at(place.file, place.line))


def own_annotations(cls: type) -> dict[str, Any]:
    """Annotations of a class, without those of its bases, that declare fields.

    Raises:
        InputError: An attribute is a type, such as `times = int`, so that it was probably meant as an annotation.
    """
    hints = inspect.get_annotations(cls)
    for name, value in vars(cls).items():
        is_meant = name[0].islower() and name not in hints and _is_type(value) and not _is_inherited(cls, name)
        if is_meant and definition_of(cls) is not None:  # no class of an installed package
            message = f"'{name}' of '{cls.__name__}' is set to a type, which declares nothing."
            hint = f"Write '{name}: ...', with a colon, to declare a value; or '_{name} = ...' for another attribute."
            raise class_error(cls, message, hint)
    return {name: hint for name, hint in hints.items() if name[0] != "_" and "ClassVar" not in str(hint)}


def _is_type(value: object) -> bool:
    """Whether a value is a type as annotations have them: one of a plain value, or `Metres`, `list[int]` and so on."""
    return any(value is kind for kind in _PLAIN) or typing.get_origin(value) is not None


def _is_inherited(cls: type, name: str) -> bool:
    return any(name in vars(base) or name in inspect.get_annotations(base) for base in cls.__mro__[1:])


def _is_member(base: type, name: str) -> bool:
    """Whether a field must not have the name of an attribute of a base class: of any in rocs_bt, else of a method."""
    if base.__module__.partition(".")[0] == "rocs_bt":
        return name in vars(base) or name in inspect.get_annotations(base)
    return hasattr(vars(base).get(name), "__get__")


def _is_checkable(kind: Any) -> bool:
    """Whether `isinstance` accepts a type, as it does not for a Protocol, a TypedDict, a variable or a value."""
    if kind is Any or kind is Literal or isinstance(kind, InitVar):
        return True
    try:
        isinstance(None, kind)
    except TypeError:
        return False
    return True


def summary_of(cls: type) -> str:
    """First paragraph of the docstring of a class, in one line."""
    return " ".join((inspect.getdoc(cls) or "").partition("\n\n")[0].split())


@functools.cache
def docs_of(cls: type) -> Mapping[str, str]:
    """Entries of the section `Attributes:` in the docstring of a class, each in one line, by name."""
    section = (inspect.getdoc(cls) or "").partition("\nAttributes:\n")[2].partition("\n\n")[0]
    entries = _ENTRY.findall(section)
    return {name: " ".join(text.split()) for names, text in entries for name in re.split(r",\s*", names)}


def _is_list(value: object) -> bool:
    """Whether a value is a list of any kind, such as an array of numpy."""
    return isinstance(value, Collection) and not isinstance(value, (str, bytes, Mapping))


@dataclass
class Scope:
    """What a reading knows beside its document.

    Attributes:
        names: Names of the things that the document declares, by kind.
        missing: Fault of content that cannot be used, by kind and name; None if it can.
        load: Class of a reference `file.py:Class`; None for an open table, if no code of content may run.
        optional: Names of fields that need no value in this reading; they have a harmless one.
    """

    names: dict[str, Collection[str]] = field(default_factory=dict)
    missing: Callable[[str, str], Fault | None] = lambda kind, name: None
    load: Callable[[str], type[Declared] | None] = lambda name: None
    optional: Collection[str] = ()


@dataclass_transform(kw_only_default=True, eq_default=False)
class Declared:
    """Base of what a user writes in a file or in Python: its annotations are the keys, their defaults the defaults.

    A name with an underscore, and a `ClassVar`, is no field. Objects are made by keyword; callers in Python are trusted
    for types. Nothing is generated when a class is defined.
    """

    _names: ClassVar[tuple[str, ...]] = ()
    _defaults: ClassVar[Mapping[str, Any]] = {}
    _fields: ClassVar[tuple[Field, ...]]
    _table: ClassVar[Table | None] = None

    def __init_subclass__(cls, **more: Any) -> None:
        super().__init_subclass__(**more)
        own = {base: own_annotations(base) for base in reversed(cls.__mro__) if issubclass(base, Declared)}
        known = {name for base in own if base is not cls for name in own[base]}
        for name, base in ((name, base) for name in own[cls] if name not in known for base in cls.__mro__[1:]):
            if _is_member(base, name):
                message = f"'{name}' cannot be a field of '{cls.__name__}': it is a member of {base.__name__}."
                raise class_error(cls, message, "Choose another name.")
        cls._names = tuple(dict.fromkeys(name for names in own.values() for name in names))
        mro = [vars(base) for base in reversed(cls.__mro__)]
        given = ((name, members[name]) for members in mro for name in cls._names if name in members)
        cls._defaults = {name: value for name, value in given if not isinstance(value, property)}

    def __init__(self, /, **given: Any) -> None:
        if more := sorted(given.keys() - set(self._names)):
            name = type(self).__name__
            raise TypeError(f"{name} takes no {', '.join(more)}. {did_you_mean(more[0], self._names, name)}")
        if lack := [name for name in self._names if name not in given and name not in self._defaults]:
            raise TypeError(f"{type(self).__name__} needs {', '.join(lack)}")
        self.__dict__.update({name: given.get(name, self._defaults.get(name)) for name in self._names})
        self.__post_init__()

    def __post_init__(self) -> None:
        """Compute further attributes."""

    def __repr__(self) -> str:
        return f"{type(self).__name__}({', '.join(f'{key}={value!r}' for key, value in values_of(self).items())})"

    @classmethod
    def _prepare(cls, table: Table, scope: Scope) -> None:
        """Look at a table before it is read: add names to the scope, note faults of keys that exclude each other."""

    def _check(self) -> Iterator[Wrong]:
        """Faults of values that do not fit each other; asked only if each one is valid."""
        return iter(())

    def _made(self) -> Any:
        """What is read from the table: this object, or another value that it makes."""
        return self


class Value(Declared):
    """Declared class with objects that do not change, and are equal if their values are."""

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError(f"{type(self).__name__} does not change. Use replaced(..., {name}=...).")

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Value) and type(self) is type(other) and values_of(self) == values_of(other)

    def __hash__(self) -> int:
        return hash((type(self), *values_of(self).values()))


def fields_of(cls: type[Declared]) -> tuple[Field, ...]:
    """Fields of a declared class in order, those of its bases first.

    Raises:
        InputError: An annotation declares no field, or the class is a dataclass or has slots for its fields.
    """
    if (known := vars(cls).get("_fields")) is not None:
        return cast(tuple[Field, ...], known)
    if hasattr(cls, "__dataclass_fields__"):
        raise class_error(cls, f"'{cls.__name__}' is a dataclass.", _NO_DATACLASS)
    if any(isinstance(getattr(cls, name, None), types.MemberDescriptorType) for name in cls._names):
        raise class_error(cls, f"'{cls.__name__}' has slots for its values.", "Remove __slots__.")
    hints = typing.get_type_hints(cls, include_extras=True)
    owners = {name: base for base in reversed(cls.__mro__) for name in inspect.get_annotations(base)}
    defaults = cls._defaults
    cls._fields = tuple(Field.annotated(n, hints[n], defaults.get(n, MISSING), owners[n]) for n in cls._names)
    return cls._fields


def keys_of(cls: type[Declared]) -> set[str]:
    """Keys that a table of a declared class may have, without those that belong to the value of another key."""
    found = set[str]()
    for each in fields_of(cls):
        if (inner := each.mark(Keys)) is not None and inner.here:
            found |= keys_of(inner.cls)
        elif (more := each.mark(Rest)) is not None:
            found |= set(more.keys)
        elif (added := each.mark(Registered)) is not None:
            found |= set(added.names)
        elif each.is_key:
            found.add(each.key)
    return found


def values_of(of: Declared) -> dict[str, Any]:
    """Values of the fields, by name."""
    return {name: of.__dict__[name] for name in of._names}


def given_of(of: Declared) -> dict[str, Any]:
    """Values other than the defaults, by name."""
    return {name: v for name, v in values_of(of).items() if v != of._defaults.get(name, MISSING)}


def replaced(of: D, /, **changes: Any) -> D:
    """Copy with other values of some fields, at the same place.

    Raises:
        TypeError: There is no such field.
    """
    made = type(of)(**{**values_of(of), **changes})
    if of._table is not None:
        made.__dict__["_table"] = of._table
    return made


def options_of(cls: type[Declared]) -> Mapping[str, tuple[Field, Option]]:
    """Options that a class declares, by name; those of its bases last."""
    fields = sorted(fields_of(cls), key=lambda each: each.owner is not cls)
    return {each.name: (each, option) for each in fields if (option := each.mark(Option)) is not None}
