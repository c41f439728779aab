"""MJCF before MuJoCo reads it: which files it names, and how much it asks for.

MuJoCo opens whatever file a model names, and compiles whatever it describes, however long that takes. So each model is
read here first: every file must be inside the project, and every count within a limit that compiles in seconds.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from xml.parsers import expat

from ...confine import confined, is_file
from ...errors import Fault, InputError

MOST_ELEMENTS = 20_000
"""Elements of a model, with all copies."""

MOST_COPIES = 4_000
"""Elements that `replicate`, `attach` and `flexcomp` make; their cost grows with the square."""

MOST_JOINTS = 4_000
"""Joints of a model."""

MOST_CELLS = 1 << 26
"""Pixels of all textures and cells of all height fields."""

MOST_TEXT = 16 << 20
"""Bytes of a model's XML files."""

MOST_ASSETS = 64 << 20
"""Bytes of all meshes, textures, skins and height fields."""

MOST_FILES = 100
"""Files that a model includes, or attaches in a row."""

_MOST_DEPTH = 500
_MOST = {  # of single numbers, as MuJoCo allocates in proportion
    "size": {"nuserdata": 1e7, "nkey": 1e4, "njmax": 1e6, "nconmax": 1e6, "nstack": 1e8},
    "mesh": {"params": 1e3},
}
_MOST_USER = 1e4  # of the `nuser_...` of <size>
_PNG = b"\x89PNG\r\n\x1a\n"
_FOLDERS = {"texture": ("texturedir", "assetdir"), "flexcomp": ("", "meshdir", "assetdir")}
_MESHES = ("meshdir", "assetdir")


def examine_model(file: Path, roots: Iterable[Path]) -> None:
    """Refuse a model that names files outside of some folders, or asks for too much.

    Args:
        file: The MJCF file.
        roots: Folders that it may name files of, besides its own.

    Raises:
        InputError: It is no MJCF, names a file outside of the folders, or is beyond a limit; with line and column.
    """
    limits = _Limits((*roots, file.resolve().parent))
    _Model(file, limits, ()).read()


@dataclass(frozen=True)
class _Place:
    """An element of an MJCF file."""

    file: Path
    line: int
    column: int

    def fault(self, message: str, hint: str = "") -> InputError:
        return InputError(Fault(message, self.file, self.line, self.column, hint))


@dataclass(frozen=True)
class _Asset:
    """A file that an element names."""

    tag: str
    named: str
    place: _Place


@dataclass
class _Count:
    """Things that a model makes; `copies` are those of replicate, attach and flexcomp."""

    elements: float = 0.0
    copies: float = 0.0
    joints: float = 0.0

    def add(self, place: _Place, elements: float, copies: float, joints: float = 0.0) -> None:
        """Add things.

        Raises:
            InputError: There are too many.
        """
        self.elements, self.copies, self.joints = self.elements + elements, self.copies + copies, self.joints + joints
        for count, most, what in (
            (self.copies, MOST_COPIES, "elements from replicate, attach and flexcomp"),
            (self.elements, MOST_ELEMENTS, "elements"),
            (self.joints, MOST_JOINTS, "joints"),
        ):
            if count > most:
                raise place.fault(f"the model has {count:g} {what} or more; {most} are the most.", "Make fewer.")


@dataclass
class _Limits:
    """What a model with all its parts has used up so far."""

    roots: tuple[Path, ...]
    text: float = field(default_factory=lambda: MOST_TEXT)
    assets: float = field(default_factory=lambda: MOST_ASSETS)
    cells: float = field(default_factory=lambda: MOST_CELLS)
    assets_read: set[Path] = field(default_factory=set)
    models: dict[Path, _Count] = field(default_factory=dict)

    def take(self, what: str, amount: float, place: _Place, words: str) -> None:
        """Use up some of a limit.

        Raises:
            InputError: That is more than there is.
        """
        left = getattr(self, what) - amount
        setattr(self, what, left)
        if left < 0:
            raise place.fault(f"the model has {words}.", "Make it smaller.")


class _Model:
    """A main MJCF file with what it includes; models that it attaches are models of their own."""

    def __init__(self, file: Path, limits: _Limits, above: tuple[Path, ...]) -> None:
        self.file = file
        self.limits = limits
        self.above = (*above, file.resolve())
        parents = (file.absolute(), *reversed(self.above))
        self.folders = tuple(dict.fromkeys(path.parent for path in parents))  # its own first
        self.files = {file.resolve()}
        self.count = _Count()
        self.assets: list[_Asset] = []
        self.models: dict[str, _Asset] = {}
        self.attached: list[tuple[str, float, _Place]] = []
        self.dirs: dict[str, list[str]] = {}
        self.strip = False

    def read(self) -> _Count:
        """Read it and all its parts.

        Raises:
            InputError: It is refused.
        """
        _Reader(self, self.file, "mujoco").parse()
        for asset in self.assets:
            self._asset(asset)
        counts = {name: self._child(model) for name, model in self.models.items()}
        for name, times, place in self.attached:
            if (child := counts.get(name)) is not None:
                self.count.add(place, child.elements * times, child.elements * times, child.joints * times)
        return self.count

    def include(self, named: str, times: float, place: _Place) -> None:
        """Read an included file, each once; MuJoCo looks for it beside the main file."""
        for folder in dict.fromkeys((*self.folders, place.file.parent)):
            path = self._confined(named, folder, place)
            if is_file(path) and path not in self.files:
                if len(self.files) >= MOST_FILES:
                    raise place.fault(f"the model is made of more than {MOST_FILES} files.", "Join some.")
                self.files.add(path)
                _Reader(self, path, "", times).parse()

    def _child(self, model: _Asset) -> _Count:
        for folder in self.folders:
            path = self._confined(model.named, folder, model.place)
            if path in self.above or len(self.above) > MOST_FILES:
                raise model.place.fault(f"'{model.named}' attaches itself.", "Take one model out.")
            if is_file(path):
                if path not in self.limits.models:
                    self.limits.models[path] = _Model(path, self.limits, self.above).read()
                return self.limits.models[path]
        return _Count()

    def _asset(self, asset: _Asset) -> None:
        named = Path(asset.named.rpartition("\\")[2]).name if self.strip else asset.named
        keys = _FOLDERS.get(asset.tag, _MESHES)
        subs = [sub for key in keys for sub in self.dirs.get(key, [])] or [""]
        for folder in self.folders:
            for sub in dict.fromkeys([*subs, *([""] if "" in keys else [])]):
                path = self._confined(str(Path(sub, named)), folder, asset.place)
                if is_file(path) and path not in self.limits.assets_read:
                    self.limits.assets_read.add(path)
                    self._open(path, asset.place)

    def _open(self, path: Path, place: _Place) -> None:
        size = path.stat().st_size
        self.limits.take("assets", size, place, f"more than {MOST_ASSETS >> 20} MB of meshes and pictures")
        with path.open("rb") as file:
            head = file.read(24)
        if head.startswith(_PNG):
            width, height = int.from_bytes(head[16:20], "big"), int.from_bytes(head[20:24], "big")
            self.limits.take("cells", width * height, place, f"pictures of more than {MOST_CELLS} pixels")

    def _confined(self, named: str, folder: Path, place: _Place) -> Path:
        try:
            return confined(named, folder, self.limits.roots)
        except InputError as error:
            raise error.at(place.file, place.line, place.column) from error


class _Reader:
    """One XML file of a model, element by element."""

    def __init__(self, model: _Model, file: Path, root: str, times: float = 1.0) -> None:
        self.model = model
        self.file = file
        self.root = root
        self.times = [times]  # copies of what is inside each open element
        self.parser = expat.ParserCreate()
        self.parser.StartElementHandler = self._start
        self.parser.EndElementHandler = lambda tag: self.times.pop()
        self.parser.StartDoctypeDeclHandler = self._doctype

    def parse(self) -> None:
        try:
            self.parser.Parse(self._text(), True)
        except expat.ExpatError as error:
            message = f"not a valid MJCF model: {expat.ErrorString(error.code)}."
            raise InputError(Fault(message, self.file, error.lineno, error.offset + 1)) from error

    def _text(self) -> str:
        file = self.file
        try:
            size = file.stat().st_size
            self.model.limits.take("text", size, _Place(file, 0, 0), f"more than {MOST_TEXT >> 20} MB of XML")
            return file.read_bytes().decode("utf-8-sig")
        except OSError as error:
            raise InputError(Fault(f"cannot read the file: {error.strerror}.", file)) from error
        except UnicodeDecodeError as error:
            message = f"the file is not UTF-8 text: {error.reason} at byte {error.start}."
            raise InputError(Fault(message, file)) from error

    def _place(self) -> _Place:
        return _Place(self.file, self.parser.CurrentLineNumber, self.parser.CurrentColumnNumber + 1)

    def _doctype(self, *_: object) -> None:
        raise self._place().fault("an MJCF file has no document type.", "Take the <!DOCTYPE> out.")

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        place, times, model = self._place(), self.times[-1], self.model
        if len(self.times) == 1 and self.root and tag != self.root:
            hint = "MuJoCo's compile tool turns a URDF into one." if tag == "robot" else ""
            raise place.fault(f"not a valid MJCF model: it begins with <{tag}>, not <{self.root}>.", hint)
        if len(self.times) > _MOST_DEPTH:
            raise place.fault(f"elements are nested more than {_MOST_DEPTH} deep.")
        _check_numbers(tag, attributes, place)
        model.count.add(place, times, times if times > 1.0 else 0.0, times if tag in ("joint", "freejoint") else 0.0)
        if tag not in ("include", "model"):
            model.assets += [_Asset(tag, v, place) for key, v in attributes.items() if key.startswith("file") and v]
        if (handle := _HANDLERS.get(tag)) is not None:
            handle(model, attributes, times, place)
        self.times.append(times * max(_number(attributes.get("count", "1")), 1.0) if tag == "replicate" else times)


def _check_numbers(tag: str, attributes: Mapping[str, str], place: _Place) -> None:
    """Refuse numbers that MuJoCo allocates in proportion to.

    Raises:
        InputError: One is too large.
    """
    limits = _MOST.get(tag, {})
    for key, value in attributes.items():
        most = _MOST_USER if tag == "size" and key.startswith("nuser_") else limits.get(key, math.inf)
        if (number := max(_numbers(value), default=0.0)) > most:
            raise place.fault(f"{key} of <{tag}> is {number:g}; {most:g} is the most.", "Make it smaller.")


def _include(model: _Model, attributes: Mapping[str, str], times: float, place: _Place) -> None:
    if named := attributes.get("file", ""):
        model.include(named, times, place)


def _compiler(model: _Model, attributes: Mapping[str, str], times: float, place: _Place) -> None:
    for key in ("meshdir", "texturedir", "assetdir"):
        if key in attributes:
            model.dirs.setdefault(key, []).append(attributes[key])
    if "strippath" in attributes:
        model.strip = attributes["strippath"] == "true"


def _model(model: _Model, attributes: Mapping[str, str], times: float, place: _Place) -> None:
    if named := attributes.get("file", ""):
        model.models[attributes.get("name") or Path(named).stem] = _Asset("model", named, place)


def _attach(model: _Model, attributes: Mapping[str, str], times: float, place: _Place) -> None:
    model.attached.append((attributes.get("model", ""), times, place))


def _flexcomp(model: _Model, attributes: Mapping[str, str], times: float, place: _Place) -> None:
    counts = _numbers(attributes.get("count", "10 10 10"))
    made = 0.0 if "file" in attributes or "mesh" in attributes else math.prod(max(count, 1.0) for count in counts)
    made = times * (made + len(attributes.get("point", "").split()) / 3.0)
    model.count.add(place, made, made)


def _cells(names: Sequence[str], each: float) -> Callable[[_Model, Mapping[str, str], float, _Place], None]:
    def handle(model: _Model, attributes: Mapping[str, str], times: float, place: _Place) -> None:
        sizes = [_number(attributes.get(name, "0")) for name in names]
        words = f"textures and height fields of more than {MOST_CELLS} cells"
        model.limits.take("cells", each * math.prod(sizes), place, words)

    return handle


_HANDLERS: Mapping[str, Callable[[_Model, Mapping[str, str], float, _Place], None]] = {
    "include": _include,
    "compiler": _compiler,
    "model": _model,
    "attach": _attach,
    "flexcomp": _flexcomp,
    "texture": _cells(("width", "height"), 1.0),
    "hfield": _cells(("nrow", "ncol"), 1.0),
}


def _number(text: str) -> float:
    return max(_numbers(text), default=0.0)


def _numbers(text: str) -> list[float]:
    """The numbers in an attribute; what is none is MuJoCo's to refuse."""
    found = []
    for word in text.split()[:16]:
        try:
            found.append(float(word))
        except ValueError:
            continue
    return [number for number in found if number == number]
