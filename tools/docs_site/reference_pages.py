"""Writes api/*.md, a page for each public header, from Doxygen's output for their comments.

Usage: reference_pages.py REPOSITORY WORK
Pages go to WORK/pages/api. Exit status 1, with the place, if Doxygen misreads a comment or a type has no description.
"""

import pathlib
import re
import subprocess
import sys
import xml.etree.ElementTree as ElementTree


def public_headers(repository):
    """The installed headers of C++, and those of the component vtk. The header for C is its own reference."""
    build_rules = (repository / "palpa/CMakeLists.txt").read_text(encoding="utf-8")
    lists = re.findall(r"palpa_install_headers\(([^)]*)\)|foreach\(header ([^)]*)\)", build_rules)
    return [header for names in lists for header in " ".join(names).split() if header != "c.h"]


def read_comments(repository, work, headers):
    (work / "Doxyfile").write_text(f"""
INPUT = {' '.join(f'palpa/{header}' for header in headers)}
OUTPUT_DIRECTORY = {work}
STRIP_FROM_PATH = {repository}
GENERATE_HTML = NO
GENERATE_LATEX = NO
GENERATE_XML = YES
XML_PROGRAMLISTING = NO
QUIET = YES
JAVADOC_AUTOBRIEF = NO
AUTOLINK_SUPPORT = NO
WARN_IF_UNDOCUMENTED = NO
WARN_IF_INCOMPLETE_DOC = NO
""", encoding="utf-8")
    run = subprocess.run(["doxygen", work / "Doxyfile"], cwd=repository, stderr=subprocess.PIPE, text=True, check=True)
    return run.stderr.strip().splitlines()


def escaped(text):
    """Words of a comment as escaped Markdown."""
    return re.sub(r"([\\`*_\[\]<>|])", r"\\\1", re.sub(r"\s+", " ", text or ""))


def words(node):
    """Content of a paragraph."""
    out = escaped(node.text)
    for child in node:
        inside = "".join(child.itertext())
        if child.tag == "computeroutput":
            # A name that ends in a character of Markdown's own is safe between two marks of code.
            out += f"`{inside.strip()}`"
        elif child.tag in ("simplesect", "parameterlist", "itemizedlist", "verbatim", "programlisting"):
            out += "\n\n" + block(child) + "\n\n"
        elif child.tag == "bold":
            out += f"**{escaped(inside)}**"
        elif child.tag == "emphasis":
            out += f"*{escaped(inside)}*"
        elif child.tag == "ndash":
            out += "–"
        else:
            out += words(child)
        out += escaped(child.tail)
    return out.strip() if node.tag == "para" else out


def block(node):
    if node.tag == "para":
        return words(node)
    if node.tag == "itemizedlist":
        return "\n".join("- " + " ".join(block(child) for child in item).replace("\n", " ") for item in node)
    if node.tag == "parameterlist":
        rows = []
        for item in node:
            names = ", ".join(f"`{''.join(name.itertext())}`" for name in item.iter("parametername"))
            rows.append(f"- {names}: {described(item.find('parameterdescription'))}")
        return "\n".join(rows)
    if node.tag == "simplesect":
        label = {"return": "Returns ", "note": "Note: "}.get(node.get("kind"), "")
        return label + " ".join(block(child) for child in node)
    if node.tag in ("verbatim", "programlisting"):
        return "```\n" + "".join(node.itertext()).strip("\n") + "\n```"
    return words(node)


def described(*nodes):
    return "\n\n".join(block(child) for node in nodes if node is not None for child in node if "".join(child.itertext()).strip()).strip()


def description(node):
    return described(node.find("briefdescription"), node.find("detaileddescription"))


def text_of(node, tag):
    found = node.find(tag)
    return re.sub(r"\s+", " ", "".join(found.itertext())).strip() if found is not None else ""


def as_written(text):
    """Types as in the headers: Doxygen inserts blanks that the style does not have."""
    text = re.sub(r"\s+([&*]+)", r"\1", text)
    text = re.sub(r"([&*])(?=[A-Za-z_])", r"\1 ", text)
    return re.sub(r"<\s+", "<", re.sub(r"\s+>", ">", text)).strip()


def declaration(member):
    """A member's declaration, without its body."""
    kind = member.get("kind")
    name, kind_of = text_of(member, "name"), as_written(text_of(member, "type"))
    if kind == "enum":
        strong = "class " if member.get("strong") == "yes" else ""
        return f"enum {strong}{name} {{ {', '.join(text_of(value, 'name') for value in member.iter('enumvalue'))} }};"
    if kind == "define":
        parameters = [text_of(parameter, "defname") for parameter in member.findall("param")]
        return f"#define {name}" + (f"({', '.join(parameters)})" if parameters else "")
    if kind == "typedef":
        definition = as_written(text_of(member, "definition"))
        return f"using {name} = {definition.split(' = ', 1)[1]};" if " = " in definition else definition + ";"
    template = member.find("templateparamlist")
    begin = ""
    if template is not None:
        begin = "template <" + ", ".join(" ".join(filter(None, (text_of(p, "type"), text_of(p, "declname")))) for p in template) + ">\n"
    if kind == "function":
        static = "static " if member.get("static") == "yes" and "static" not in kind_of else ""
        end = as_written(text_of(member, "argsstring"))
        return f"{begin}{static}{kind_of}{' ' if kind_of else ''}{name}{re.sub(r' *= *', ' = ', end)};".replace("operator = = ", "operator==")
    initial = text_of(member, "initializer")
    return f"{begin}{kind_of} {name}{text_of(member, 'argsstring')}{' ' + initial if initial.startswith('=') else initial};"


def cell(text):
    return text.replace("\n", " ").replace("|", "\\|") if "\\|" not in text else text.replace("\n", " ")


def line_of(node):
    return int(node.find("location").get("line"))


def members_text(members, level):
    """A struct's values as a table; all else as declared, members without words below the member before them."""
    values = [m for m in members if m.get("kind") == "variable"]
    out = []
    if values:
        out += ["| value | type | at first | |\n|---|---|---|---|"]
        for m in values:
            initial = re.sub(r"^=\s*", "", text_of(m, "initializer"))
            kind = as_written(text_of(m, "type")).replace("|", "\\|")
            out[-1] += f"\n| `{text_of(m, 'name')}` | `{kind}` | {'`' + initial.replace('|', chr(92) + '|') + '`' if initial else ''} | {cell(description(m))} |"
    together, last_words = [], ""

    def close():
        if together:
            out.append("```cpp\n" + "\n".join(together) + "\n```\n\n" + last_words)

    for m in sorted((m for m in members if m.get("kind") != "variable"), key=line_of):
        spoken = description(m)
        if m.get("kind") == "enum":
            lines = [f"- `{text_of(v, 'name')}`: {description(v)}" for v in m.iter("enumvalue") if description(v)]
            spoken = "\n\n".join(filter(None, [spoken, "\n".join(lines)]))
        if spoken or not together:
            close()
            together, last_words = [declaration(m)], spoken
        else:
            together.append(declaration(m))
    close()
    return out


def page_of(header):
    return header[:-2].replace("/", "-")


def main():
    repository, work = map(pathlib.Path, sys.argv[1:])
    headers = public_headers(repository)
    problems = read_comments(repository, work, headers)
    of_header = {header: [] for header in headers}
    for path in sorted((work / "xml").glob("*.xml")):
        if path.name == "index.xml":
            continue
        compound = ElementTree.parse(path).getroot().find("compounddef")
        if compound is None or compound.find("location") is None:
            continue
        kind, name = compound.get("kind"), text_of(compound, "compoundname")
        if "::detail" in name or compound.get("prot") == "private":
            continue
        if kind in ("struct", "class"):
            header = compound.find("location").get("file").removeprefix("palpa/")
            if header in of_header:
                of_header[header].append((line_of(compound), kind, name, compound))
                if not description(compound) and "::" not in name.removeprefix("palpa::"):
                    problems.append(f"palpa/{header}:{line_of(compound)}: nothing is said of {name}; a comment that begins with ///")
        elif kind in ("namespace", "file"):
            for member in compound.iter("memberdef"):
                header = member.find("location").get("file").removeprefix("palpa/")
                if header in of_header and member.get("prot") == "public" and not text_of(member, "name").startswith("PALPA_DETAIL"):
                    of_header[header].append((line_of(member), "member", text_of(member, "name"), member))

    # Each header's purpose is in a table of docs/embedding.md.
    rows = re.findall(r"^\| (.*?) \| (.*`.*) \|$", (repository / "docs/embedding.md").read_text(encoding="utf-8"), re.M)
    pages = work / "pages/api"
    pages.mkdir(parents=True, exist_ok=True)
    shown = set()
    lines = []
    for purpose, names in rows:
        of_row = [name for name in re.findall(r"`([a-z_0-9/]+\.h)`", names) if name in of_header and name not in shown]
        shown.update(of_row)
        if of_row:
            lines.append(f"| {purpose} | {', '.join(f'[`{name}`]({page_of(name)}.md)' for name in of_row)} |")
    rest = [header for header in headers if header not in shown]
    lines.append(f"| for programs that have VTK | {', '.join(f'[`{name}`]({page_of(name)}.md)' for name in rest)} |")
    (pages / "index.md").write_text(
        "# API reference\n\nThe public headers of the library, in the words of their own comments. [Embedding](../docs/embedding.md) shows "
        "how a program uses them. Everything is in the namespace `palpa`.\n\n| for | headers |\n|---|---|\n" + "\n".join(lines) +
        "\n\n```{toctree}\n:hidden:\n\n" + "\n".join(page_of(header) for header in headers) + "\n```\n", encoding="utf-8")

    for header, entries in of_header.items():
        text = (repository / "palpa" / header).read_text(encoding="utf-8") if (repository / "palpa" / header).exists() else ""
        about = re.match(r"(?:// .*\n)+", text)
        out = [f"# `{header}`"]
        if about:
            out.append(escaped(re.sub(r"^// ", "", about.group(0), flags=re.M)))
        if text:
            out.append(f"```cpp\n#include <palpa/{header}>\n```\n\n[The header itself](../palpa/{header})")
        together = []
        for _, kind, name, node in sorted(entries, key=lambda entry: entry[:1]):
            if kind == "member":
                together.append(node)
                continue
            if together:
                out += functions(together)
                together = []
            bases = ", ".join(as_written("".join(base.itertext())) for base in node.findall("basecompoundref"))
            short = name.removeprefix("palpa::")
            out.append(f"## `{short}`")
            out.append(f"```cpp\n{kind} {short}{' : ' + bases if bases else ''};\n```")
            out.append(description(node))
            members = [m for section in node.findall("sectiondef") for m in section.findall("memberdef")
                       if m.get("prot") == "public" and m.get("kind") != "friend" and not text_of(m, "argsstring").endswith(("=delete", "=default"))]
            out += members_text(members, 3)
        out += functions(together)
        (pages / f"{page_of(header)}.md").write_text("\n\n".join(filter(None, out)) + "\n", encoding="utf-8")

    for problem in problems:
        print(problem, file=sys.stderr)
    return 1 if problems else 0


def functions(members):
    """Free functions and others outside of classes, each name with a heading; members without words belong to the one before."""
    out, group = [], []
    for member in members:
        if group and not description(member) and member.get("kind") == "function":
            group.append(member)
            continue
        out += entry(group)
        group = [member]
    return out + entry(group)


def entry(group):
    if not group:
        return []
    first = group[0]
    out = [f"## `{text_of(first, 'name')}`"] if text_of(first, "name") else []
    out.append("```cpp\n" + "\n".join(declaration(member) for member in group) + "\n```")
    out.append(description(first))
    if first.get("kind") == "enum":
        values = [f"- `{text_of(v, 'name')}`: {description(v)}" for v in first.iter("enumvalue") if description(v)]
        out.append("\n".join(values))
    return out


if __name__ == "__main__":
    sys.exit(main())
