"""The notebooks of docs run as printed, with the printed output; plots need matplotlib."""

import json
import pathlib
import sys

import numpy as np
import pytest

import palpa

source = pathlib.Path(__file__).resolve().parents[2]
notebooks = sorted((source / "docs/notebooks").glob("*.ipynb"))


def cells(notebook):
    return [c for c in json.loads(notebook.read_text(encoding="utf-8"))["cells"] if c["cell_type"] == "code"]


def test_there_are_three_and_each_stands_there_with_what_it_shows():
    assert [n.stem for n in notebooks] == ["first_touch", "own_mode", "what_if"]
    for notebook in notebooks:
        assert any(cell["outputs"] for cell in cells(notebook)), notebook
        assert all(output["output_type"] != "error" for cell in cells(notebook) for output in cell["outputs"]), notebook
    shown = [output["data"] for cell in cells(notebooks[0]) for output in cell["outputs"] if "data" in output]
    assert sum("image/png" in data for data in shown) == 2, "a scene and a trace"


@pytest.mark.parametrize("notebook", notebooks, ids=lambda n: n.stem)
def test_each_runs_from_top_to_end(notebook, tmp_path, monkeypatch):
    """Runs its cells in one namespace, as a kernel would; checks assertions and output."""
    pytest.importorskip("matplotlib")
    monkeypatch.chdir(tmp_path)
    names, printed = {}, []
    monkeypatch.setitem(names, "print", lambda *words: printed.append(" ".join(map(str, words))))
    for cell in cells(notebook):
        printed.clear()
        exec(compile("".join(cell["source"]), notebook.name, "exec"), names)
        stands = "".join("".join(o["text"]) for o in cell["outputs"] if o["output_type"] == "stream" and o["name"] == "stdout")
        assert "".join(line + "\n" for line in printed) == stands


def test_plots_are_pictures_or_say_what_is_missing(monkeypatch):
    scene = palpa.Scene(max_force_n=0.3)
    scene.add("ball", palpa.sphere_field())
    scene.add("wall", palpa.SurfaceAndFriction(field="ball", levels=[dict(value=0, strength_n=2)]))
    trace = palpa.run(scene, "sim:press", duration_s=0.8)
    with monkeypatch.context() as without:
        without.setitem(sys.modules, "matplotlib.figure", None)
        with pytest.raises(ImportError, match="install python3-matplotlib"):
            trace.plot()
        assert scene._repr_png_() is None and "<table>" in trace._repr_html_(), "words are shown then"
    pytest.importorskip("matplotlib")
    force, depth = trace.plot().axes
    (spring,) = [line for line in force.lines if line.get_label() == "spring"]
    np.testing.assert_array_equal(spring.get_ydata(), np.linalg.norm(trace.ticks["force_n"], axis=1))
    (sent,) = [line for line in force.lines if line.get_label() == "reaches the hand"]
    assert max(sent.get_ydata()) < 0.31 < max(spring.get_ydata())
    assert {"wall"} <= {line.get_label() for line in force.lines} and depth.lines
    for png in (trace._repr_png_(), scene._repr_png_()):
        assert png.startswith(b"\x89PNG") and len(png) > 5000
    assert scene.plot().axes[0].collections, "the level that is felt is a line in the slice"
