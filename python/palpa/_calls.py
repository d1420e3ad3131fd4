"""One-sentence errors for calls of C++ that match no signature."""

import re

from ._parameters import _there_are

_takes = {"float": "a number", "int": "a whole number", "bool": "True or False", "str": "a text", "dict": "a dict", "tuple": "a tuple"}


def _parameters(doc, name):
    """(name, annotation, default or None, keyword only) for each parameter of a docstring's first signature."""
    line = re.search(rf"^{re.escape(name)}\((.*?)\)(?: ->.*)?$", doc or "", re.M)
    parameters, keyword_only = [], False
    depth, piece, pieces = 0, "", []
    for letter in (line[1] if line else "") + ",":
        depth += (letter in "([") - (letter in ")]")
        if letter == "," and depth == 0:
            pieces.append(piece.strip())
            piece = ""
        else:
            piece += letter
    for piece in pieces:
        if piece == "*":
            keyword_only = True
            continue
        if match := re.fullmatch(r"(\w+): (.*?)(?: = (.*))?", piece):
            parameters.append((match[1], re.sub(r"palpa\._palpa\.|palpa\.", "", match[2]), match[3], keyword_only))
    return parameters


def _fits(annotation, value):
    """True if a value may match an annotation of pybind11, or the annotation is unknown."""
    if annotation == "bool":
        return isinstance(value, bool) or type(value).__name__ in ("bool_", "bool")
    if annotation == "float":
        return hasattr(value, "__float__") or hasattr(value, "__index__")
    if annotation == "int":
        return hasattr(value, "__index__")
    if annotation == "str":
        return isinstance(value, str)
    import palpa

    cls = getattr(palpa, annotation, None)
    return not isinstance(cls, type) or isinstance(value, cls)


def sentence(called, doc, given, named):
    """Error of a call.

    called: Session.tick; Scene for its constructor, Field() for a call of an object, Scene.title = for an assignment.
    given, named: its arguments, without self."""
    if called.endswith(" ="):
        annotation = re.search(r"arg\d+: ([\w.]+)\) -> None", doc or "")
        what = annotation and _takes.get(annotation[1])
        value = given[0] if given else None
        return f"{called[:-2]} takes {what or 'another value'}, not {type(value).__name__}"
    name = (re.match(r"(\w+)\(", doc or "") or [None, called])[1]
    parameters = [each for each in _parameters(doc, name) if each[0] != "self"]
    names = [each[0] for each in parameters]
    by_place = [each for each in parameters if not each[3]]
    said = ", ".join(("*, " if each[3] and (n == 0 or not parameters[n - 1][3]) else "") + each[0]
                     + (f"={each[2]}" if each[2] is not None else "") for n, each in enumerate(parameters))
    takes = f"it is {called}({said})"
    for word in named:
        if word not in names:
            return f"{called}: no parameter {word!r}; " + (_there_are(word, names) if names else "it takes none")
    if len(given) > len(by_place):
        if len(parameters) > len(by_place):
            return f"{called}: {names[len(by_place)]!r} is said by its name; {takes}"
        return f"{called}: takes {len(by_place)} arguments, not {len(given)}; {takes}"
    values = {**{each[0]: value for each, value in zip(by_place, given)}, **named}
    for parameter, _, default, _ in parameters:
        if default is None and parameter not in values:
            return f"{called}: {parameter!r} is missing; {takes}"
    for parameter, annotation, default, _ in parameters:
        if parameter in values and not (values[parameter] is None and default == "None") and not _fits(annotation, values[parameter]):
            what = _takes.get(annotation, f"a palpa.{annotation}")
            return f"{called}: {parameter!r} takes {what}, not {type(values[parameter]).__name__}"
    return f"{called}: cannot be called with these values; {takes}"

