"""Writes palpa/__init__.pyi, the type stubs for checkers and editors, from the package itself.

    make_stubs.py OUT     with the package on PYTHONPATH
"""

import inspect
import re
import sys

import palpa

head = '''"""Written by python/make_stubs.py; do not edit."""

from collections.abc import Iterable, Mapping, Sequence
from os import PathLike
from pathlib import Path
from typing import Any, ClassVar, Literal, NamedTuple, final

from numpy import ndarray
from numpy.typing import ArrayLike

__version__: str
__all__: list[str]
'''


def is_bound(thing):
    """True for a C++ function, which has its signature in its docstring."""
    return "pybind11" in str(type(thing)) or "builtin" in str(type(thing)) or type(thing).__name__ == "instancemethod"


def in_python(text):
    """Signature of pybind11 as Python annotations."""
    text = re.sub(r"palpa(\._palpa)?\.", "", text)
    text = re.sub(r"numpy\.ndarray(\[[^\]]*\])?", "ndarray", text)
    text = re.sub(r"\b(\w+): object = None", r"\1: ArrayLike | None = ...", text)
    text = re.sub(r"\b(\w+): object\b", r"\1: ArrayLike", text)
    text = re.sub(r"\b([iI]terable)\b(?!\[)", "Iterable[Any]", text).replace("-> object", "-> Any")
    text = re.sub(r"\b(List|Dict|Tuple)\b", lambda m: m[1].lower(), text)
    for bare, full in (("dict", "dict[str, Any]"), ("list", "list[Any]"), ("tuple", "tuple[Any, ...]")):
        text = re.sub(rf"(-> |: ){bare}(?!\[)\b", rf"\1{full}", text)
    text = re.sub(r"Union\[([^\[\]]+)\]", lambda m: m[1].replace(", ", " | "), text)
    text = re.sub(r"self: \w+", "self", text)
    return re.sub(r"= [^,)]+", "= ...", text)


def signature_of(doc, name):
    line = re.search(rf"^{re.escape(name)}\((.*)$", doc or "", re.M)
    if not line:
        return "(*args: Any, **kwargs: Any) -> Any"
    return in_python("(" + line[1])


def function(name, thing, indent=""):
    if is_bound(thing):
        return f"{indent}def {name}{signature_of(thing.__doc__, name)}: ..."
    signature = inspect.signature(thing)
    parameters = []
    if name == "__init__" and thing is palpa.Scene.__init__:  # parameters of its coupling
        signature = signature.replace(return_annotation=None, parameters=[
            p if p.name in ("self", "tool") else p.replace(annotation="float | None" if p.default is None else float) for p in signature.parameters.values()])
    for parameter in signature.parameters.values():
        default = parameter.default if parameter.default is inspect.Parameter.empty else ...
        parameters.append(parameter.replace(default=default))
    text = str(signature.replace(parameters=parameters)).replace("Ellipsis", "...").replace("'", "")
    text = text.replace("numpy.typing.ArrayLike", "ArrayLike").replace("_palpa.", "").replace("numpy.ndarray", "ndarray")
    return f"{indent}def {name}{text}: ..."


def listed_class(cls, indent=""):
    """Stub of a class with a list of parameters."""
    name = cls.__name__
    base = cls.__mro__[1].__name__
    lines = [f"{indent}@final", f"{indent}class {name}{'(Mode)' if base == '_ListedMode' else ''}:"]
    items = {key: item for key, item in vars(cls).items() if isinstance(item, type)}
    for item in items.values():
        lines += listed_class(item, indent + "    ")
    arguments = []
    for attribute in cls._attributes:
        annotation = getattr(cls, attribute).__doc__.split(":")[0]
        read = annotation
        if annotation.startswith("Sequence[") and annotation[9:-1].split(".")[-1] in items:
            item = annotation[9:-1].split(".")[-1]
            read, annotation = f"tuple[{name}.{item}, ...]", f"Sequence[{name}.{item} | dict[str, Any]]"
        arguments.append(f"{attribute}: {annotation} = ...")
        lines += [f"{indent}    @property", f"{indent}    def {attribute}(self) -> {read}: ...",
                  f"{indent}    @{attribute}.setter", f"{indent}    def {attribute}(self, value: {annotation}) -> None: ..."]
    lines += [f"{indent}    def __init__(self, *, {', '.join(arguments)}) -> None: ...",
              f"{indent}    def __eq__(self, other: object) -> bool: ..."]
    return lines


def is_said(thing):
    """True for a C++ constructor that can be called."""
    return (thing.__doc__ or "").startswith("__init__(self") and "Overloaded" not in thing.__doc__


def property_type(cls, name, thing):
    if name == "needs":
        return "Sequence[str]"
    if thing.fget is not None and is_bound(thing.fget):
        returned = re.search(r"-> (.*)", thing.fget.__doc__ or "")
        return in_python(returned[0])[3:] if returned else "Any"
    if isinstance(cls, type) and name in ("coupling", "workspace", "time"):
        return {"coupling": "CouplingOptions", "workspace": "Workspace", "time": "TimeOptions"}[name]
    if name == "scene":
        return "Scene"
    if cls is palpa.Volume and name == "fields":
        return "Mapping[str, Field]"
    if cls is palpa.Scene and name in palpa.CouplingOptions._attributes:
        return thing.__doc__.split(":")[0]
    return str(inspect.signature(thing.fget).return_annotation).strip("'")


def plain_class(cls):
    name = cls.__name__
    if issubclass(cls, tuple):
        return [f"class {name}(NamedTuple):"] + [
            f"    {field}: {getattr(kind, '__forward_arg__', kind)}" for field, kind in cls.__annotations__.items()]
    bases = [base for base in cls.__bases__ if base.__name__ not in ("object", "pybind11_object", "Strict")]
    if cls is palpa.Scene:
        members = {**vars(cls.__mro__[1]), **vars(cls)}
        bases = []
    else:
        members = dict(vars(cls))
    lines = [f"class {name}{'(' + ', '.join(base.__name__ for base in bases) + ')' if bases else ''}:"]
    for each, kind in vars(cls).get("__annotations__", {}).items():
        lines.append(f"    {each}: {kind}".replace("numpy.", ""))
    for each, thing in members.items():
        if each == "__getattr__" and cls is not palpa.Trace:  # only for suggestions, which a checker has, too
            continue
        special = each in ("__init__", "__call__", "__eq__", "__enter__", "__exit__", "__getattr__", "__hash__")
        if each.startswith("_") and not special or thing is None or each == "__hash__" and thing is None:
            continue
        if isinstance(thing, property):
            kind = property_type(cls, each, thing)
            lines += ["    @property", f"    def {each}(self) -> {kind}: ..."]
            if thing.fset is not None:
                lines += [f"    @{each}.setter", f"    def {each}(self, value: {kind}) -> None: ..."]
        elif each == "__eq__":
            lines.append("    def __eq__(self, other: object) -> bool: ...")
        elif callable(thing):
            if each == "__init__" and (is_bound(thing) or "slot wrapper" in str(thing)) and not is_said(thing):
                continue
            lines.append(function(each, thing, "    "))
        elif type(thing).__name__ == name:  # enumerator
            lines.append(f"    {each}: ClassVar[{name}]")
    if len(lines) == 1:
        lines.append("    ...")
    return lines


def stubs():
    lines = [head]
    for name in palpa.__all__:
        thing = getattr(palpa, name)
        if isinstance(thing, type):
            lines += listed_class(thing) if hasattr(thing, "_attributes") else plain_class(thing)
        elif callable(thing):
            lines.append(function(name, thing))
        lines.append("")
    text = "\n".join(lines).replace("_palpa.", "")
    text = re.sub(r"Optional\[(\w+)\]", r"\1 | None", text)
    text = re.sub(r"\bndarray\b(?!\[|$)", "ndarray[Any, Any]", text, flags=re.M)
    text = re.sub(r"-> tuple:", "-> tuple[Any, ...]:", text)
    return re.sub(r"\bPathLike\b(?! *(\[|$))", "PathLike[str]", text, flags=re.M)


if __name__ == "__main__":
    with open(sys.argv[1], "w", encoding="utf-8") as file:
        file.write(stubs())
