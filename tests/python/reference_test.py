"""The reference of the package: a page for each class, by its docstrings."""

import pathlib
import subprocess
import sys

import palpa

source = pathlib.Path(__file__).resolve().parents[2]


def test_every_class_has_a_page_with_all_of_its_members(tmp_path):
    told = subprocess.run([sys.executable, source / "tools/docs_site/python_pages.py", tmp_path], capture_output=True, text=True)
    assert told.returncode == 0, told.stderr
    pages = tmp_path / "pages/api"
    contents = (pages / "python.md").read_text()
    for name in palpa.__all__:
        thing = getattr(palpa, name)
        if not isinstance(thing, type):
            assert f"## `{name}`" in (pages / "python-functions.md").read_text() or not callable(thing), name
            continue
        text = (pages / f"python-{name}.md").read_text()
        assert f"(python-{name}.md)" in contents and f"\npython-{name}\n" in contents
        for member in vars(thing):
            if hasattr(thing, "__members__") and member in ("name", "value"):
                continue  # of every enumeration
            if not member.startswith("_") and vars(thing)[member] is not None and not isinstance(vars(thing)[member], type):
                assert member in text, (name, member)
    follow = (pages / "python-Follow.md").read_text()
    assert "- `strength_n`: float \\| Strength\n  force that holds the hand on the line" in follow and "0.5" in follow
    session = (pages / "python-Session.md").read_text()
    assert "def " not in session and "tick(position_m: ArrayLike" in session and "One update: modes place primitives" in session
    assert "ticks(positions_m: ArrayLike, dt_s: ArrayLike, turns_rad: ArrayLike | None = ...) -> Ticks" in session


def test_a_class_without_words_is_found(tmp_path):
    program = ("import sys, runpy, palpa\nclass Bare: pass\npalpa.Bare = Bare\npalpa.__all__.append('Bare')\n"
               f"sys.argv = ['', {str(tmp_path)!r}]\nrunpy.run_path({str(source / 'tools/docs_site/python_pages.py')!r}, run_name='__main__')")
    told = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert told.returncode == 1 and told.stderr == "palpa.Bare: nothing is said of it; a docstring\n"
