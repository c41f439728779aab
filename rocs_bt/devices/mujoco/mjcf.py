"""Check of MJCF files before MuJoCo reads them: which files they reference, and how large the model is.

MuJoCo opens every file that a model references, and compiles models of any size. Each model is therefore checked first:
every referenced file must be inside the project, and every count within a limit that compiles in seconds.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from xml.parsers import expat

from ...base.errors import Fault, InputError
from ...base.files import confined, is_file, read_bytes, read_text

MOST_ELEMENTS = 20_000
"""Maximum number of elements of a model, including all copies."""

MOST_COPIES = 4_000
"""Maximum number of elements that `replicate`, `attach` and `flexcomp` create; their cost grows quadratically."""

MOST_JOINTS = 4_000
"""Maximum number of joints of a model."""

MOST_CELLS = 1 << 26
"""Maximum number of pixels of all textures and cells of all height fields."""

MOST_TEXT = 16 << 20
"""Maximum size of a model's XML files [bytes]."""

MOST_ASSETS = 64 << 20
"""Maximum size of all meshes, textures, skins and height fields [bytes]."""

MOST_FILES = 100
"""Maximum number of included files, and maximum depth of attached models."""

_MOST_DEPTH = 500
_MOST = {  # maxima of attributes that determine how much memory MuJoCo allocates
    "size": {"nuserdata": 1e7, "nkey": 1e4, "njmax": 1e6, "nconmax": 1e6, "nstack": 1e8},
    "mesh": {"params": 1e3},
}
_MOST_USER = 1e4  # maximum of the attributes `nuser_...` of <size>
_PNG = b"\x89PNG\r\n\x1a\n"
_FOLDERS = {"texture": ("texturedir", "assetdir"), "flexcomp": ("", "meshdir", "assetdir")}
_MESHES = ("meshdir", "assetdir")


def examine_model(file: Path, roots: Iterable[Path]) -> None:
    """Check a model: the files that it references, and its size.

    The model may reference files in its own folder and in those of `roots`.

    Raises:
        InputError: The file is not valid MJCF, references a file outside of the folders, or exceeds a limit; with line
            and column.
    """
    limits = _Limits((*roots, file.resolve().parent))
    _Model(file, limits, ()).read()


@dataclass(frozen=True)
class _Location:
    """Location of an element in an MJCF file."""

    file: Path
    line: int
    column: int

    def fault(self, message: str, hint: str = "") -> InputError:
        return InputError(Fault(message, self.file, self.line, self.column, hint))


@dataclass(frozen=True)
class _Asset:
    """Reference from an element of a model to a file, such as a mesh."""

    tag: str
    named: str
    location: _Location


@dataclass
class _Count:
    """Numbers of elements of a model; `copies` are those that replicate, attach and flexcomp create."""

    elements: float = 0.0
    copies: float = 0.0
    joints: float = 0.0

    def add(self, location: _Location, elements: float, copies: float, joints: float = 0.0) -> None:
        """Add to the counts the elements at one location; raises InputError."""
        self.elements, self.copies, self.joints = self.elements + elements, self.copies + copies, self.joints + joints
        for count, most, what in (
            (self.copies, MOST_COPIES, "elements from replicate, attach and flexcomp"),
            (self.elements, MOST_ELEMENTS, "elements"),
            (self.joints, MOST_JOINTS, "joints"),
        ):
            if count > most:
                raise location.fault(f"the model has {count:g} {what} or more; the maximum is {most}.", "Use fewer.")


@dataclass
class _Limits:
    """Remaining budgets for the size of a model, including the models that it attaches."""

    roots: tuple[Path, ...]
    text: float = field(default_factory=lambda: MOST_TEXT)
    assets: float = field(default_factory=lambda: MOST_ASSETS)
    cells: float = field(default_factory=lambda: MOST_CELLS)
    assets_read: set[Path] = field(default_factory=set)
    models: dict[Path, _Count] = field(default_factory=dict)

    def take(self, what: str, amount: float, location: _Location, words: str) -> None:
        """Consume part of the budget `text`, `assets` or `cells`; raises InputError."""
        left = getattr(self, what) - amount
        setattr(self, what, left)
        if left < 0:
            raise location.fault(f"the model has {words}.", "Make it smaller.")


class _Model:
    """Model under check: its main MJCF file and included files. Each attached model is a `_Model` of its own."""

    def __init__(self, file: Path, limits: _Limits, above: tuple[Path, ...]) -> None:
        self.file = file
        self.limits = limits
        self.above = (*above, file.resolve())
        parents = (file.absolute(), *reversed(self.above))
        self.folders = tuple(dict.fromkeys(path.parent for path in parents))  # the model's own folder first
        self.files = {file.resolve()}
        self.count = _Count()
        self.assets: list[_Asset] = []
        self.models: dict[str, _Asset] = {}
        self.attached: list[tuple[str, float, _Location]] = []
        self.dirs: dict[str, list[str]] = {}
        self.strip = False

    def read(self) -> _Count:
        """Read the model and its attached models; returns the counts of their elements. Raises InputError."""
        _Reader(self, self.file, "mujoco").parse()
        for asset in self.assets:
            self._asset(asset)
        counts = {name: self._child(model) for name, model in self.models.items()}
        for name, times, location in self.attached:
            if (child := counts.get(name)) is not None:
                self.count.add(location, child.elements * times, child.elements * times, child.joints * times)
        return self.count

    def include(self, named: str, times: float, location: _Location) -> None:
        """Read an included file, unless it was read before. MuJoCo resolves its path relative to the main file."""
        for folder in dict.fromkeys((*self.folders, location.file.parent)):
            path = self._confined(named, folder, location)
            if is_file(path) and path not in self.files:
                if len(self.files) >= MOST_FILES:
                    raise location.fault(f"the model consists of more than {MOST_FILES} files.", "Merge some.")
                self.files.add(path)
                _Reader(self, path, "", times).parse()

    def _child(self, model: _Asset) -> _Count:
        for folder in self.folders:
            path = self._confined(model.named, folder, model.location)
            if path in self.above or len(self.above) > MOST_FILES:
                raise model.location.fault(f"'{model.named}' attaches itself.", "Remove one model.")
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
                path = self._confined(str(Path(sub, named)), folder, asset.location)
                if is_file(path) and path not in self.limits.assets_read:
                    self.limits.assets_read.add(path)
                    self._open(path, asset.location)

    def _open(self, path: Path, location: _Location) -> None:
        size = path.stat().st_size
        self.limits.take("assets", size, location, f"more than {MOST_ASSETS >> 20} MB of meshes and pictures")
        try:
            head = read_bytes(path)[:24]
        except OSError as error:
            raise location.fault(f"cannot read '{path.name}': {error.strerror}.", "Choose another file.") from error
        if head.startswith(_PNG):
            width, height = int.from_bytes(head[16:20], "big"), int.from_bytes(head[20:24], "big")
            self.limits.take("cells", width * height, location, f"pictures of more than {MOST_CELLS} pixels")

    def _confined(self, named: str, folder: Path, location: _Location) -> Path:
        try:
            return confined(named, folder, self.limits.roots)
        except InputError as error:
            raise error.at(location.file, location.line, location.column) from error


class _Reader:
    """Reader of one XML file of a model."""

    def __init__(self, model: _Model, file: Path, root: str, times: float = 1.0) -> None:
        self.model = model
        self.file = file
        self.root = root
        self.times = [times]  # number of copies of the content of each open element
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
        text = read_text(self.file)
        self.model.limits.take("text", len(text), _Location(self.file, 0, 0), f"more than {MOST_TEXT >> 20} MB of XML")
        return text.removeprefix("\ufeff")

    def _location(self) -> _Location:
        return _Location(self.file, self.parser.CurrentLineNumber, self.parser.CurrentColumnNumber + 1)

    def _doctype(self, *_: object) -> None:
        raise self._location().fault("an MJCF file must not have a document type.", "Remove the <!DOCTYPE>.")

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        location, times, model = self._location(), self.times[-1], self.model
        if len(self.times) == 1 and self.root and tag != self.root:
            hint = "MuJoCo's compile tool converts URDF to MJCF." if tag == "robot" else ""
            raise location.fault(f"not a valid MJCF model: it begins with <{tag}>, not <{self.root}>.", hint)
        if len(self.times) > _MOST_DEPTH:
            raise location.fault(f"elements are nested more than {_MOST_DEPTH} deep.")
        _check_numbers(tag, attributes, location)
        model.count.add(location, times, times if times > 1.0 else 0.0, times if tag in ("joint", "freejoint") else 0.0)
        if tag not in ("include", "model"):
            model.assets += [_Asset(tag, v, location) for key, v in attributes.items() if key.startswith("file") and v]
        if (handle := _HANDLERS.get(tag)) is not None:
            handle(model, attributes, times, location)
        self.times.append(times * max(_number(attributes.get("count", "1")), 1.0) if tag == "replicate" else times)


def _check_numbers(tag: str, attributes: Mapping[str, str], location: _Location) -> None:
    """Check the attributes that determine how much memory MuJoCo allocates; raises InputError."""
    limits = _MOST.get(tag, {})
    for key, value in attributes.items():
        most = _MOST_USER if tag == "size" and key.startswith("nuser_") else limits.get(key, math.inf)
        if (number := max(_numbers(value), default=0.0)) > most:
            raise location.fault(f"{key} of <{tag}> is {number:g}; the maximum is {most:g}.", "Reduce it.")


def _include(model: _Model, attributes: Mapping[str, str], times: float, location: _Location) -> None:
    if named := attributes.get("file", ""):
        model.include(named, times, location)


def _compiler(model: _Model, attributes: Mapping[str, str], times: float, location: _Location) -> None:
    for key in ("meshdir", "texturedir", "assetdir"):
        if key in attributes:
            model.dirs.setdefault(key, []).append(attributes[key])
    if "strippath" in attributes:
        model.strip = attributes["strippath"] == "true"


def _model(model: _Model, attributes: Mapping[str, str], times: float, location: _Location) -> None:
    if named := attributes.get("file", ""):
        model.models[attributes.get("name") or Path(named).stem] = _Asset("model", named, location)


def _attach(model: _Model, attributes: Mapping[str, str], times: float, location: _Location) -> None:
    model.attached.append((attributes.get("model", ""), times, location))


def _flexcomp(model: _Model, attributes: Mapping[str, str], times: float, location: _Location) -> None:
    counts = _numbers(attributes.get("count", "10 10 10"))
    made = 0.0 if "file" in attributes or "mesh" in attributes else math.prod(max(count, 1.0) for count in counts)
    made = times * (made + len(attributes.get("point", "").split()) / 3.0)
    model.count.add(location, made, made)


def _cells(names: Sequence[str], each: float) -> Callable[[_Model, Mapping[str, str], float, _Location], None]:
    def handle(model: _Model, attributes: Mapping[str, str], times: float, location: _Location) -> None:
        sizes = [_number(attributes.get(name, "0")) for name in names]
        words = f"textures and height fields of more than {MOST_CELLS} cells"
        model.limits.take("cells", each * math.prod(sizes), location, words)

    return handle


_HANDLERS: Mapping[str, Callable[[_Model, Mapping[str, str], float, _Location], None]] = {
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
    """Numbers in an attribute, without NaN and invalid values, which MuJoCo reports itself."""
    found = []
    for word in text.split()[:16]:
        try:
            found.append(float(word))
        except ValueError:
            continue
    return [number for number in found if number == number]
