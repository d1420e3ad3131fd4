"""Writes api/python*.md, a page for each class of the Python package, from its docstrings, parameter lists and type stubs.

Usage: python_pages.py WORK     with the package on PYTHONPATH, its stubs beside it
Pages go to WORK/pages/api. Exit status 1, with the name, if a class or a member has no description.
"""

import inspect
import pathlib
import re
import sys

import palpa


def escaped(text):
    """Text of Markdown; what stands between two backticks is code there, too."""
    return "".join(part if n % 2 else re.sub(r"([\\*_\[\]<>|])", r"\\\1", part) for n, part in enumerate(re.split(r"(`[^`]+`)", text)))


def in_markdown(doc):
    """A docstring as Markdown: indented blocks are code, `name : meaning` lines are items."""
    out, is_item = [], False
    for line in inspect.cleandoc(doc or "").splitlines():
        match = re.fullmatch(r" *([\w, ]+) : (.*)", line)
        if match and not line.startswith("    "):
            if out and not is_item:
                out.append("")
            out.append(f"- `{match[1].strip()}`: {escaped(match[2])}")
            is_item = True
        elif line.startswith("    ") and is_item:
            out.append("  " + escaped(line.strip()))
        elif line.startswith("    "):
            out.append(line)
        else:
            if out and line and (is_item or out[-1].startswith("    ")):
                out.append("")
            is_item = is_item and not line
            out.append(escaped(line))
    return "\n".join(out)


def declarations(stubs):
    """{class or "": {member: declarations}} of the stubs, in their order."""
    of, inside = {"": {}}, ""
    marks = []
    for line in stubs.splitlines():
        if match := re.match(r"class (\w+)", line):
            inside, marks = match[1], []
            of[inside] = {}
        elif line.startswith("def "):
            of[""].setdefault(re.match(r"def (\w+)", line)[1], []).append(line.removesuffix(" ..."))
        elif line and not line.startswith(" "):
            marks = []
        elif re.match(r"    @", line):
            marks.append(line.strip())
        elif match := re.match(r"    def (\w+)(.*): \.\.\.", line):
            name, is_property = match[1], "@property" in marks
            if not any(mark.endswith(".setter") for mark in marks):
                text = f"{name}: {match[2].partition('-> ')[2]}" if is_property else f"{name}{match[2]}"
                of[inside].setdefault(name, []).append(re.sub(r"\(self(: \w+)?(, )?", "(", text, count=1))
            marks = []
        elif match := re.match(r"    (\w+): (.*)", line):
            of[inside].setdefault(match[1], []).append(match[0].strip())
    return of


def doc_of(thing, name):
    """Text of a member: that of C++ without the line of its signature."""
    doc = inspect.getdoc(thing) or ""
    return re.sub(rf"^{name}\(.*\) -> .*\n+", "", doc)


def page_of(name, cls, members, problems):
    out = [f"# `palpa.{name}`", in_markdown(cls.__doc__)]
    if not (cls.__doc__ or "").strip():
        problems.append(f"palpa.{name}: nothing is said of it; a docstring")
    listed = getattr(cls, "_attributes", ())
    for member, texts in members.items():
        if member.startswith("__") or member in listed or hasattr(cls, "__members__") and member in ("name", "value"):
            continue
        thing = inspect.getattr_static(cls, member, None)
        told = doc_of(getattr(cls, member, thing), member) if not isinstance(thing, property) else thing.__doc__ or ""
        is_value = thing is None or not (isinstance(thing, property) or callable(thing) or isinstance(thing, staticmethod))
        if not told.strip() and not is_value and not getattr(thing, "__doc__", None):
            problems.append(f"palpa.{name}.{member}: nothing is said of it; a docstring")
        out.append("```python\n" + "\n".join(texts) + "\n```" + ("" if is_value else "\n\n" + in_markdown(told)))
    return "\n\n".join(out) + "\n"


def main():
    pages = pathlib.Path(sys.argv[1]) / "pages/api"
    pages.mkdir(parents=True, exist_ok=True)
    of = declarations((pathlib.Path(palpa.__file__).parent / "__init__.pyi").read_text(encoding="utf-8"))
    problems, rows, functions = [], [], ["# Functions of `palpa`"]
    for name in palpa.__all__:
        thing = getattr(palpa, name)
        if isinstance(thing, type):
            (pages / f"python-{name}.md").write_text(page_of(name, thing, of.get(name, {}), problems), encoding="utf-8")
            first = escaped(inspect.cleandoc(thing.__doc__ or "").partition("\n")[0])
            rows.append(f"| [`{name}`](python-{name}.md) | {first} |")
        elif callable(thing):
            told = doc_of(thing, name)
            if not told.strip():
                problems.append(f"palpa.{name}: nothing is said of it; a docstring")
            functions.append(f"## `{name}`\n\n```python\n" + "\n".join(of[""].get(name, [name])) + f"\n```\n\n{in_markdown(told)}")
    (pages / "python-functions.md").write_text("\n\n".join(functions) + "\n", encoding="utf-8")
    contents = "\n".join(["python-functions", *(f"python-{name}" for name in palpa.__all__ if isinstance(getattr(palpa, name), type))])
    (pages / "python.md").write_text(
        "# Python reference\n\nThe classes of the package `palpa`, in the words of their own docstrings; [Python](../docs/python.md) "
        "shows their use. [Functions](python-functions.md).\n\n| class | |\n|---|---|\n" + "\n".join(rows)
        + f"\n\n```{{toctree}}\n:hidden:\n\n{contents}\n```\n", encoding="utf-8")
    for problem in problems:
        print(problem, file=sys.stderr)
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
