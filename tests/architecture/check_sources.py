#!/usr/bin/env python3
"""Checks the promises of the folders; prints a line for each broken promise: check_sources.py

Layers include one another along the arrows of docs/design.md; foreign libraries stay in their layers; public numbers have a
unit; types of the library's headers have different names; no function has more than 60 lines; files, locale and terminal
are used in one place. exceptions.py lists the exceptions.
"""

import pathlib
import re
import sys
from exceptions import internal, knows_toml, words

product = ("palpa", "reader", "app", "explorer", "devices", "net", "python")
unit_name = re.compile(r"(.*_(U|(U|n_s|ns|ticks)_per_U|per_U|bytes)|per_U|newtons|metres|seconds|bytes)"
                       r"(_(min|max|mean|p50|p99|sum))?".replace("U", "(m|mm|um|m2|m3|s|ms|us|n|nm|nms|j|hz|kg|deg|rad)"))
unit_comment = re.compile(r"\[1\]|\[[^\],;_(){}]*[A-Za-z][^\],;_(){}]*\]|own unit")
literal = re.compile(r'//[^\n]*|/\*.*?\*/|R"(\w*)\(.*?\)\1"|"(?:\\.|[^"\\\n])*"|(?<![0-9a-fA-F])\'(?:\\.|[^\'\\\n])*\'|'
                     r'^[ \t]*#(?:\\\n|[^\n])*', re.S | re.M)
declared = re.compile(r"\b(?:double|float|Vec3)\b(?:\s|&|\*|>|const\b|,\s*\w+\s*>)*\b(?!operator)([A-Za-z_]\w*)\b(?!\s*::)")
posix = re.compile(r"(sys/\w+|unistd|fcntl|signal|spawn|poll|stddef|stdint)\.h$")
access = re.compile(r"\b(public|private|protected)\s*:(?!:)")


def blank(text):
    return re.sub(r"[^\n]", " ", text)


def code_of(text):
    """The source with comments, literals and directives blanked, at unchanged positions."""
    return literal.sub(lambda found: ('""' if found[0][0] in "\"'R" else "  ") + blank(found[0])[2:], text)


def line_of(text, at):
    return text.count("\n", 0, at) + 1


def blocks_of(code):
    """Every block in braces as (statement before it, its begin, position of {, position of }, depth of functions around it)."""
    blocks, stack, begin = [], [], 0
    for found in re.finditer(r"[;{}()]|\b(public|private|protected)\s*:", code):
        mark, at = found[0], found.start()
        if mark == "{":
            head = re.sub(r"^\s*template\s*<.*?>\s*(?=[a-z])", "", code[begin:at], flags=re.S).strip()
            kind = ("value" if not head or not code[at - 1].isspace() or head.count("(") > head.count(")")
                    or re.search(r"=|\benum\b|\breturn\b", head.split("(")[0]) else
                    "namespace" if re.search(r"\bnamespace\b[\s\w:]*$", head) else "function" if "(" in head else
                    "class" if re.search(r"\b(class|struct|union)\b", head) else "value")
            stack.append((kind, head, begin, at))
            begin = at + 1 if kind != "value" or re.search(r"\benum\b", head) else begin
        elif mark == "}" and stack:
            kind, head, start, open_at = stack.pop()
            blocks.append((kind, head, start, open_at, at, [each[0] for each in stack]))
            begin = at + 1 if kind != "value" or re.search(r"\benum\b", head) else begin
        elif mark not in "()" and (mark != ";" or code.count("(", begin, at) <= code.count(")", begin, at)):
            begin = found.end()
    return blocks


def functions_of(text):
    """(name, first line, lines) of each outermost function."""
    code, found = code_of(text), []
    for kind, head, start, _, end, around in blocks_of(code):
        if kind == "function" and not {"function", "value"} & set(around):
            name, first = re.findall(r"[~\w]+", head.split("(")[0])[-1], re.compile(r"\s*").match(code, start).end()
            found.append((name, line_of(code, first), code.count("\n", first, end) + 1))
    return found


def public_code(text):
    """The code without bodies of functions, initialisers, private members, namespaces detail and unnamed."""
    code = code_of(text)
    shown = list(code)
    for kind, head, _, begin, end, _ in blocks_of(code):
        if kind in ("function", "value") or kind == "namespace" and re.search(internal, head):
            shown[begin:end + 1] = (" " if kind == "value" and "enum" not in head else ";") + blank(code[begin + 1:end + 1])
        elif kind == "class":
            inside, parts, at = "".join(shown[begin + 1:end]), "", 0
            public = re.search(r"\b(struct|union)\b", head)
            for label in [*access.finditer(inside), re.search(r"\Z", inside)]:
                part = inside[at:label.start()]
                parts += (part if public else blank(part)) + (";" + blank(label[0][1:]) if label[0] else "")
                public, at = label[0].startswith("public"), label.end()
            shown[begin + 1:end] = parts
    return "".join(shown)


def unitless_numbers(text):
    """(line, name) of the public numbers without a unit in their name or comment."""
    lines, code, found = text.split("\n") + [""], public_code(text), []
    comment = lambda line: "".join(re.findall("//.*", lines[line - 1]))
    for statement in re.finditer(r"[^;{}]+", code):
        if re.match(r"\s*(using|friend|typedef)\b", statement[0]):
            continue
        first, above = line_of(code, statement.start() + len(statement[0]) - len(statement[0].lstrip())), []
        while lines[first - 2 - len(above)].lstrip().startswith("//"):
            above.append(lines[first - 2 - len(above)])
        for number in declared.finditer(statement[0]):
            before, behind = statement[0][:number.start()], statement[0][number.end():]
            is_parameter = before.count("(") > before.count(")")
            names = [(number[1], number.start(1))]
            if not is_parameter and not behind.lstrip().startswith("("):  # double a = 0, b = 0;
                more = re.finditer(r",\s*([A-Za-z_]\w*)", re.sub(r"\([^()]*\)", lambda call: blank(call[0]), behind))
                names += [(each[1], number.end() + each.start(1)) for each in more]
            for name, at in names:
                line = line_of(code, statement.start() + at)
                said = "\n".join((*reversed(above), comment(line), comment(line_of(code, statement.end()))))
                if is_parameter:  # its unit may be on the next line
                    said = " ".join(re.findall(rf"(?:\\param\s+|`){name}\b[^\n]*", said.replace("`\n///", "`")))
                if not unit_name.fullmatch(name) and not unit_comment.search(said):
                    found.append((line, name))
    return found


def types_of(text):
    """The types of a header outside of other types and functions."""
    code = code_of(text)
    inner = [(begin, end) for kind, _, _, begin, end, _ in blocks_of(code) if kind in ("class", "function")]
    types = re.finditer(r"\b(?:class|struct|union|enum class)\s+([A-Z]\w*)\s*(?:final\s*)?(?::[^;:{][^;{]*)?\{", code)
    return [found[1] for found in types if not any(begin < found.start() < end for begin, end in inner)]


def arrows_of(page):
    """Permitted layers for each layer, itself included, from the lines with ◄ of the section on layers."""
    arrows = {}
    section = re.search(r"^## [^\n]*Layers.*?(?=^## |\Z)", page, re.S | re.M)
    for line in re.findall("^.*◄.*$", section[0] if section else "", re.M):
        seen = []
        for group in line.split("   ")[0].split("◄"):
            for layer in re.findall("[a-z]+", group):
                arrows.setdefault(layer, {layer}).update(seen)
            seen += re.findall("[a-z]+", group)
    for _ in arrows:
        for sees in arrows.values():
            sees.update(*[arrows.get(other, ()) for other in sees])
    return arrows


def wrong_includes(arrows, path, text):
    """Includes against the arrows, and foreign libraries outside of their layers."""
    is_library, is_header = path.startswith("palpa/"), path.endswith(".h")
    layer = path.removeprefix("palpa/").rpartition("/")[0].split("/")[0]
    if is_library and layer and layer not in arrows:
        yield 1, f"docs/design.md has no layer {layer}"
    for found in re.finditer(r'^[ \t]*#[ \t]*include[ \t]*([<"])([^>"]+)[>"]', text, re.M):
        name, why = found[2], ""
        other = name.split("/")[1] if name.count("/") > 1 else ""
        if name.startswith("palpa/"):
            if other and layer and other not in arrows.get(layer, ()):
                why = "against the arrows of docs/design.md"
            elif layer == "reader" and other == "file" and "protocol" not in name:
                why = "of file, the reader knows the protocol alone"
            elif is_library and layer and name == "palpa/palpa.h":
                why = "for users"
        elif is_library and found[1] == '"':
            why = "within the library headers are named from palpa/ on"
        elif re.match("vtk|itk|gdcm|Q[A-Z]", name):
            known = {"reader": ".", "explorer": "vtk|Q", "vtk": "vtk", "view": "vtk", "report": "vtk"}.get(layer, "$")
            if not re.match(known, name) or layer in ("view", "report") and is_header:
                why = "VTK is known to reader, explorer, vtk and the sources of view and report; Qt to explorer; ITK to reader"
        elif layer in ("solver", "guard", "far") and re.search("[./]", name):
            why = layer + " needs the standard library alone"
        elif is_library and is_header and path not in knows_toml and re.search("[./]", name) and not posix.match(name):
            why = "a public header needs the standard library and POSIX alone"
        if why:
            yield line_of(text, found.start()), f"includes {name}: {why}"


def check(root):
    files = [file for folder in product for file in sorted((root / folder).rglob("*")) if file.suffix in (".h", ".cpp")]
    sources = {str(file.relative_to(root)): file.read_text() for file in files}
    arrows, types = arrows_of((root / "docs/design.md").read_text()), {}
    for path, text in sources.items():
        if not path.startswith(("devices/", "net/")):  # plug-ins, of no layer
            yield from ((path, *each) for each in wrong_includes(arrows, path, text))
        yield from ((path, line, f"{name} is longer than 60 lines") for name, line, lines in functions_of(text) if lines > 60)
        if path.startswith("palpa/") and path.endswith(".h"):
            for name in types_of(text):
                types.setdefault(name, []).append(path)
            if path not in ("palpa/solver/vec3.h", "palpa/solver/pose.h"):  # vectors of any unit: their members have it
                yield from ((path, line, f"{name} says no unit; end its name with it, or say it in the comment: [1], [N], the "
                             "field's own unit") for line, name in unitless_numbers(text))
        for what, pattern, folders, instead, may in words:
            found = re.search(pattern, code_of(text)) if path.split("/")[0] in folders else None
            if found and path not in may:
                yield path, line_of(text, found.start()), f"{found[0]} {what}; use {instead}"
            if path in may and not found:
                yield path, 1, f"needs no exception: nothing in it {what}"
    yield from ((paths[0], 1, f"{name} is another type in {paths[1]}") for name, paths in types.items() if len(paths) > 1)
    if len(sources) < 300 or len(arrows) < 15 or len(types) < 200:
        yield str(root), 1, f"is not read: {len(sources)} sources, {len(arrows)} layers, {len(types)} types"


if __name__ == "__main__":
    repository = pathlib.Path(__file__).resolve().parents[2]
    broken = [f"{path}:{line}: {what}" for path, line, what in check(repository)]
    print(*broken, f"{len(broken)} promises are broken", sep="\n")
    sys.exit(bool(broken))
