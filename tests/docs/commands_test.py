"""The commands of the pages work as printed.

Every block ```sh of every page is run, line by line, the blocks of a page in sequence in one shell, in a folder laid out as
the repository. Exceptions are in `not_run`, with reasons; an exception without a line in its page is an error, and so is a
block of commands without a language.

Usage: commands_test.py SOURCE BUILD [PAGE…]      exit status 77: the program is not built
"""

import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import time

source, build = (pathlib.Path(word).resolve() for word in sys.argv[1:3])
data = pathlib.Path(os.environ.get("PALPA_SHARED", source.parent / "shared")).resolve() / "data"
# The data are hidden from a run after one with them.
is_second_run = os.environ.get("PALPA_TESTS_HIDE_DATA") == "ON"

device = "needs the device itself; stand-ins are in tests/devices"
window = "opens a window and stays; tests/explorer"
building = "builds for minutes; "
# Page, beginning of a line, reason of the exception.
not_run = [
    ("README.md", "./demo ", "installs packages and builds; tests/architecture/setup_scripts_test.sh"),
    ("README.md", "./test ", "runs this test"),
    ("README.md", "./demo --explore", window),
    ("README.md", "palpa explore first-trace", window),
    ("README.md", "palpa devices inverse3 --setup", device),
    ("README.md", "palpa run scenes/head_phantom.toml --device inverse3", device),
    ("README.md", "tools/get-ct-head", "downloads 19 MB over the network"),
    ("README.md", "./demo --web", "serves a page and stays; tests/web"),
    ("docs/browser.md", "./demo --web", "serves a page and stays; tests/web"),
    ("docs/browser.md", "tools/make-web", building + "./test does it before these tests"),
    ("docs/browser.md", "cmake --preset wasm", building + "./test does it before these tests"),
    ("docs/devices.md", "palpa devices inverse3 --setup", device),
    ("docs/devices.md", "palpa run scenes/head_phantom.toml --device inverse3", device),
    ("docs/devices.md", "palpa run scenes/head_phantom.toml --device igtl", device),
    ("docs/slicer.md", "palpa run head.toml --device igtl", device),
    ("docs/embedding.md", "cmake --build build/release", building + "this test is part of that build"),
    ("docs/embedding.md", "cmake --install", "tests/install/install_test.sh"),
    ("docs/embedding.md", "cmake --build build/release --target uninstall", "tests/install/install_test.sh"),
    ("docs/explorer.md", "palpa explore", window),
    ("docs/felt.md", "cmake --preset bench", building + "by hand, with the measurements"),
    ("docs/felt.md", "build/bench/bin/bench_felt", "a measurement, not built by the tests"),
    ("docs/gallery.md", "tools/make-pictures build/release --data DATA", "draws for minutes; one of each kind is made"),
    ("docs/gallery.md", "palpa check", "docs/check.md runs it"),
    ("docs/gallery.md", "python3 bench/haptics/picture.py", "draws what a measurement left"),
    ("docs/gallery.md", "build/bench/bin/bench_felt", "a measurement, not built by the tests"),
    ("docs/gallery.md", "cmake -S examples/07_vtk_program", "built with the examples and by tests/install/install_test.sh"),
    ("docs/gallery.md", "PICTURE=viewer.png", "tests examples.07_vtk_program do it, without the picture"),
    ("docs/gallery.md", "pvpython ", "needs ParaView and a screen; tests/trace/paraview_test.cpp tries its filters"),
    ("docs/benchmark.md", "cmake --preset bench", building + "by hand, with the measurements"),
    ("docs/benchmark.md", "tools/get-ct-head", "downloads 19 MB over the network"),
    ("docs/benchmark.md", "B=build/bench/bin", "a measurement, not built by the tests; its parts are tested in tests/haptics"),
    ("docs/benchmark.md", "$B/bench_haptics", "a measurement, not built by the tests; its parts are tested in tests/haptics"),
    ("docs/benchmark.md", "python3 bench/haptics/picture.py", "draws what the measurement left"),
    ("docs/reproduction.md", "./demo", "installs packages and builds; tests/architecture/setup_scripts_test.sh"),
    ("docs/reproduction.md", "sudo apt-get install", "installs packages; packages.txt has them"),
    ("docs/reproduction.md", "cmake -DPALPA_PYTHON=ON build/release", building + "this test is part of that build"),
    ("docs/reproduction.md", "python3 tools/figures/reproduction.py", "tests/docs/reproduction_test.sh, which compares it with the page"),
    ("docs/large.md", "mpirun ", "needs a cluster; tests/python/store_test.py starts four processes by mpirun"),
    ("docs/large.md", "palpa convert stack/", "needs a stack; tests/python/store_test.py converts one"),
    ("docs/large.md", "palpa prepare big.zarr                          ", "continues the line above"),
    ("docs/large.md", "sbatch ", "needs Slurm"),
    ("docs/large.md", "parallel ", "needs GNU parallel; tests/python/store_test.py runs parts in any order"),
    ("docs/large.md", "cmake --preset bench", building + "by hand, with the measurements"),
    ("docs/large.md", "build/bench/bin/bench_store", "a measurement, not built by the tests"),
    ("docs/large.md", "python3 bench/store.py", "a measurement"),
    ("docs/own-mode.md", "cmake -S . -B build", "tests/install/install_test.sh builds it outside; here the one of the build is taken"),
    ("docs/paraview.md", "paraview ", window),
    ("docs/security.md", "tests/fuzz/campaign", "runs for hours; short campaigns are tests of their own (fuzz.*)"),
    ("docs/security.md", "build/release/tests/palpa_campaign", "needs what a campaign found"),
    ("docs/security.md", "cmake --preset libfuzzer", building + "another compiler"),
    ("docs/security.md", "tests/fuzz/libfuzzer", building + "another compiler"),
]

one_cell = """<VTKFile type="UnstructuredGrid"><UnstructuredGrid><Piece NumberOfPoints="4" NumberOfCells="1">
<PointData><DataArray type="Float32" Name="speed" format="ascii">0 1 2 3</DataArray></PointData>
<Points><DataArray type="Float32" NumberOfComponents="3" format="ascii">0 0 0 0.02 0 0 0 0.02 0 0 0 0.02</DataArray></Points>
<Cells><DataArray type="Int32" Name="connectivity" format="ascii">0 1 2 3</DataArray>
<DataArray type="Int32" Name="offsets" format="ascii">4</DataArray>
<DataArray type="UInt8" Name="types" format="ascii">10</DataArray></Cells></Piece></UnstructuredGrid></VTKFile>
"""
# Assumed files of a page's reader: made before its first line.
given = {
    "README.md": f"ln -s $DATA/ct_headphantom_dicom ct-folder && cat >flow.vtu <<'END'\n{one_cell}END",
    "docs/contracts/file.md": """mkdir headers $HOME/raw && cp $DATA/ct_head_cranium/cranium.raw.gz $HOME/raw &&
        sed "s|^data file:.*|data file: $HOME/raw/cranium.raw.gz|" $DATA/ct_head_cranium/cranium.nhdr >headers/x.nhdr""",
    "docs/hands.md": "cp $DATA/trajectories/inverse3_woodcarving_20231121_102837.csv recording.csv",
    "docs/large.md": "head -c 18000000 /dev/urandom >big.raw",
    "docs/own-mode.md": "cp examples/04_mode_plugin/ridge.toml .",
    "docs/slicer.md": "cp scenes/head_phantom.toml head.toml",
    "docs/start.md": "cp $DATA/ct_head_cranium/cranium.* . && cp examples/04_mode_plugin/ridge.toml .",
}
# The first complete scene of a page, and its name in the page.
scene_names = {"docs/start.md": "chamber.toml"}


def pages():
    return sorted(str(path.relative_to(source)) for path in [*source.glob("*.md"), *source.glob("docs/**/*.md")])


def blocks(page, language):
    text = (source / page).read_text(encoding="utf-8")
    return re.findall(rf"^```{language}\n(.*?)^```", text, re.M | re.S)


def commands(page):
    """Lines of a page's blocks for a shell; backslashes join lines."""
    text = "".join(blocks(page, "sh")).replace("\\\n", " ")
    return [line for line in text.splitlines() if line.strip()]


def reason_not_to_run(page, line):
    reasons = [reason for of_page, beginning, reason in not_run if of_page == page and line.startswith(beginning)]
    return reasons[0] if reasons else None


def names_made_by(line):
    """The files and folders that a line writes: values of options, redirections, and of converters the last word that is no
    option's."""
    words = line.split("#")[0].split()
    made = [word for before, word in zip(words, words[1:]) if before in ("--out", "--picture", "--scene", "--fix", "-o", ">")]
    if words[:1] == ["palpa"] and words[1:2] and words[1] in ("convert", "export", "map", "report"):
        plain = [word for before, word in zip(words[1:], words[2:]) if not word.startswith("-") and not before.startswith("--")]
        made += plain[-1:] if len(plain) > 1 else []
    return set(made)


def lines_without_data(lines):
    """The lines that run without data: none that names data, and none that reads output of an omitted line."""
    kept, lacking = [], set()
    for line in lines:
        words = line.split("#")[0].split()
        reads = {word.split("/")[0] for word in words} - names_made_by(line)
        if re.search(r"\bDATA\b", line) or reads & lacking:
            lacking |= names_made_by(line)
        else:
            lacking -= names_made_by(line)
            kept.append(line)
    return kept


def problems_with_lines_without_data():
    """The rule, on made-up lines."""
    lines = ["palpa run a.toml --data DATA --out a", "palpa export a a.vtp", "palpa export b b.vtp", "grep x a.vtp", "ls a/x",
             "palpa run c.toml --out a", "palpa report a --out a.html", "tool > a.vtp", "grep x a.vtp"]
    right = ["palpa export b b.vtp", "palpa run c.toml --out a", "palpa report a --out a.html", "tool > a.vtp", "grep x a.vtp"]
    return [] if lines_without_data(lines) == right else [f"lines that need data: {lines_without_data(lines)}"]


def problems_with_lists():
    found = []
    for page, beginning, _ in not_run:
        if not any(line.startswith(beginning) for line in commands(page)):
            found.append(f"not_run: {page} has no line '{beginning}…' any more; take it from the list")
    for page in pages():
        for line in commands(page):
            for name in re.findall(r"make-pictures .*--only '?([a-z0-9_*-]+)", line):
                if not list((source / "docs/pictures").glob(f"{name}.*")):
                    found.append(f"{page}: there is no picture '{name}', which is to be made by: {line}")
    command = re.compile(r"^(palpa\s|cmake\s|source\s|tests/|tools/|build/|\./|[A-Z_]+=)", re.M)
    for page in pages():
        for block in blocks(page, ""):
            if command.search(block):
                found.append(f"{page}: a block of commands that does not begin with ```sh: {block.splitlines()[0]}")
        for page_with_python in [page] if blocks(page, "python") else []:
            if page_with_python not in ("README.md", "docs/large.md", "docs/python.md", "docs/tools.md"):
                found.append(f"{page}: has Python that tests/python/docs_test.py does not run")
    for page in [*given, *scene_names]:
        if not (source / page).is_file() or not commands(page):
            found.append(f"{page}: is given something and has no commands")
    return found


def lay_out(folder):
    """A folder like the repository: written paths are copied, all others linked, so that output stays in it."""
    for entry in source.iterdir():
        if entry.name in ("docs", "tools"):
            shutil.copytree(entry, folder / entry.name, ignore=shutil.ignore_patterns("__pycache__"))
        elif entry.name != "build" and not entry.name.startswith("."):
            (folder / entry.name).symlink_to(entry)
    (folder / "build").mkdir()
    (folder / "build/release").symlink_to(build)
    ridge = build / "bin/examples/ridge.so"
    if ridge.exists():
        (folder / "build/ridge.so").symlink_to(ridge)
    (folder / "home").mkdir()


def run(page):
    """Runs a page; returns its error, if any, and the numbers of run and omitted lines."""
    lines = [line for line in commands(page) if reason_not_to_run(page, line) is None]
    before = given.get(page, "")
    without_data = 0
    if not data.is_dir():
        kept = [] if "$DATA" in before else lines_without_data(lines)
        if is_second_run and kept == lines:  # it names no data: nothing of it would differ
            return None, 0, 0
        without_data, lines = len(lines) - len(kept), kept
    if not lines:
        return None, 0, without_data
    with tempfile.TemporaryDirectory(prefix="palpa-docs-") as name:
        folder = pathlib.Path(name)
        lay_out(folder)
        for block in blocks(page, "toml"):
            if page in scene_names and block.startswith("palpa = 1"):
                (folder / scene_names[page]).write_text(block, encoding="utf-8")
                break
        script = ["end() { echo \"this line: $line\" >&2; exit 1; }"]
        for line in filter(None, [before, *lines]):
            script += [f"line={shell_quoted(line)}", re.sub(r"(?<!\$)\bDATA\b", str(data), line), "test $? = 0 || end"]
        environment = dict(os.environ, PATH=f"{build / 'bin'}:{os.environ['PATH']}", HOME=str(folder / "home"), DATA=str(data),
                           LC_ALL="C.UTF-8")
        done = subprocess.run(["bash", "-c", "\n".join(script)], cwd=folder, env=environment, stdin=subprocess.DEVNULL,
                              capture_output=True, text=True, errors="replace", timeout=500, check=False)
    if done.returncode == 0:
        return None, len(lines), without_data
    return f"{page}: status {done.returncode}\n{done.stdout[-600:]}{done.stderr[-1200:]}", len(lines), without_data


def shell_quoted(text):
    return "'" + text.replace("'", "'\\''") + "'"


def main():
    if not (build / "bin/palpa").is_file():
        print("the program palpa is not built")
        return 77
    failed = problems_with_lists() + problems_with_lines_without_data()
    chosen = sys.argv[3:]
    every = [page for page in pages() if commands(page)]
    if not every or any(page.lstrip("-") not in every for page in chosen):
        failed.append(f"no commands in: {chosen}")
    leave = [page[1:] for page in chosen if page.startswith("-")]
    only = [page for page in chosen if not page.startswith("-")]
    total = 0
    for page in only or [page for page in every if page not in leave]:
        begin = time.monotonic()
        problem, lines, without_data = run(page)
        total += lines
        print(f"{page}: {lines} lines run, {len(commands(page)) - lines - without_data} not to be run, {without_data} without data, "
              f"{time.monotonic() - begin:.1f} s", flush=True)
        if problem:
            failed.append(problem)
    for problem in failed:
        print(problem, file=sys.stderr)
    print(f"{total} lines run, {len(failed)} failed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
