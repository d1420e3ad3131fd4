"""Modes in Python and in C."""

import ctypes
import gc
import pathlib
import subprocess
import sys
import threading
import weakref

import numpy as np
import pytest

import palpa
from session_test import path_of


class Syrup(palpa.Mode):
    """A viscosity of the user's own."""

    fields = ("field",)

    def __init__(self, field, strength_n=0.0, drag_ns_per_m=1.0):
        self.field, self.strength_n, self.drag_ns_per_m = field, strength_n, drag_ns_per_m
        self.kept = None

    def place(self, here, out):
        self.kept = here, out
        if here.scalar(self.field).inside:
            out.point(0, here.proxy_m, here.newtons(self.strength_n), here.drag(self.drag_ns_per_m))


class Rail(palpa.Mode):
    fields = ("field",)

    def __init__(self, field):
        self.field = field

    def place(self, here, out):
        sample = here.vector(self.field)
        speed = np.linalg.norm(sample.value)
        if sample.inside and speed > 0:
            out.line(0, here.proxy_m, sample.value / speed, here.newtons(0.5))


def felt(volume, mode, path=None, **keywords):
    scene = palpa.Scene(stiffness_n_per_m=400)
    scene.add("data", volume)
    scene.add("mode", mode, **keywords)
    session = palpa.Session(scene)
    return session.ticks(path_of(300) if path is None else path, 1e-3)


def same(a, b, tolerance):
    np.testing.assert_allclose(a["proxy_m"], b["proxy_m"], atol=tolerance)
    assert np.abs(a["force_n"]).max() > 0.01, "nothing was felt"


def test_a_mode_in_python_is_felt_as_the_one_in_cpp():
    same(felt(palpa.head_phantom(), Syrup("data")), felt(palpa.head_phantom(), palpa.Viscosity(field="data", drag_ns_per_m=1.0)), 1e-12)
    masks = [palpa.Mask(of="data", points=[(-1000, 0.2), (1000, 1)])]
    same(felt(palpa.head_phantom(), Syrup("data"), masks=masks),
         felt(palpa.head_phantom(), palpa.Viscosity(field="data", drag_ns_per_m=1.0), masks=masks), 1e-12)
    same(felt(palpa.lamb_oseen_vortex(), Rail("data")), felt(palpa.lamb_oseen_vortex(), palpa.Follow(field="data", strength_n=0.5)), 1e-9)


def test_what_a_mode_raises_is_raised():
    class Wrong(Syrup):
        def place(self, here, out):
            return here.nothing

    scene = palpa.Scene()
    scene.add("data", palpa.head_phantom())
    scene.add("mode", Wrong("data"))
    session = palpa.Session(scene)
    with pytest.raises(AttributeError, match="nothing"):
        session.tick((0, 0, 0), 1e-3)
    with pytest.raises(AttributeError, match="nothing"):
        session.ticks(path_of(10), 1e-3)
    with pytest.raises(AttributeError, match="nothing"):
        palpa.run(scene, "sim:press", duration_s=1)
    with pytest.raises(AttributeError, match="nothing"):  # raised again in the next call
        session.tick((0, 0, 0), 1e-3)
    scene.modes["mode"].enabled = False
    assert np.isfinite(palpa.Session(scene).tick((0, 0, 0), 1e-3).force_n).all()


def test_what_is_seen_ends_with_place():
    mode = Syrup("data")
    felt(palpa.head_phantom(), mode, path_of(5))
    with pytest.raises(RuntimeError, match="only while 'place' runs"):
        mode.kept[0].proxy_m
    with pytest.raises(RuntimeError, match="only while 'place' runs"):
        mode.kept[1].point(0, (0, 0, 0), 1)


def test_fields_are_checked():
    with pytest.raises(palpa.SceneError, match="no volume 'dta'; did you mean 'data'?"):
        felt(palpa.head_phantom(), Syrup("dta"))

    class Reads(Syrup):
        def place(self, here, out):
            here.scalar("other")

    with pytest.raises(KeyError, match="reads no field 'other'"):
        felt(palpa.head_phantom(), Reads("data"))
    with pytest.raises(NotImplementedError, match="Empty has no method 'place"):
        felt(palpa.head_phantom(), type("Empty", (palpa.Mode,), {})())


def test_a_mode_lives_as_long_as_its_scene():
    mode = Syrup("data")
    gone = weakref.ref(mode)
    scene = palpa.Scene()
    scene.add("data", palpa.head_phantom())
    scene.add("mode", mode)
    del mode
    session = palpa.Session(scene)
    del scene
    gc.collect()
    session.tick((0, 0, 0), 1e-3)
    del session
    gc.collect()
    assert gone() is None


def test_modes_in_python_in_many_threads():
    want = felt(palpa.head_phantom(), Syrup("data"))
    results = [None] * 4
    threads = [threading.Thread(target=lambda n=n: results.__setitem__(n, felt(palpa.head_phantom(), Syrup("data")))) for n in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert all(result.tobytes() == want.tobytes() for result in results)


def test_real_time_refuses_a_mode_in_python():
    scene = palpa.Scene()
    scene.add("data", palpa.head_phantom())
    scene.add("mode", Syrup("data"))
    with pytest.raises(palpa.SceneError, match="mode 'mode' is written in Python.*CFunction"):
        palpa.live(scene, hand="sim:press")
    scene.modes["mode"].enabled = False
    with palpa.live(scene, hand="sim:press", duration_s=0.1) as live:
        bad = live.scene
        bad.modes["mode"].enabled = True
        with pytest.raises(palpa.SceneError, match="written in Python"):
            live.scene = bad


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    folder = tmp_path_factory.mktemp("c")
    (folder / "modes.c").write_text("""
int syrup(const double* in, double* out) {  /* a scalar field */
  if (in[11] == 0) return 0;
  out[0] = 0; out[1] = in[0]; out[2] = in[1]; out[3] = in[2]; out[8] = 1.0;
  return 1;
}
int rail(const double* in, double* out) {   /* a vector field */
  double squared = in[12] * in[12] + in[13] * in[13] + in[14] * in[14], length = squared, n;
  if (in[11] == 0 || squared == 0) return 0;
  for (n = 0; n < 60; ++n) length = 0.5 * (length + squared / length);
  out[0] = 1; out[1] = in[0]; out[2] = in[1]; out[3] = in[2];
  out[4] = in[12] / length; out[5] = in[13] / length; out[6] = in[14] / length; out[7] = 0.5;
  return 1;
}
int nonsense(const double* in, double* out) { int n; for (n = 0; n < 144; ++n) out[n] = -1e308 * 1e308; return 1 << 30; }
""")
    subprocess.run(["cc", "-shared", "-fPIC", "-O2", "-o", folder / "modes.so", folder / "modes.c"], check=True)
    return ctypes.CDLL(str(folder / "modes.so"))


def test_a_function_of_c_is_felt_as_the_mode_in_cpp(library):
    same(felt(palpa.head_phantom(), palpa.CFunction(library.syrup, scalars=["data"])),
         felt(palpa.head_phantom(), palpa.Viscosity(field="data", drag_ns_per_m=1.0)), 1e-12)
    same(felt(palpa.lamb_oseen_vortex(), palpa.CFunction(library.rail, vectors=["data"])),
         felt(palpa.lamb_oseen_vortex(), palpa.Follow(field="data", strength_n=0.5)), 1e-9)
    nonsense = felt(palpa.head_phantom(), palpa.CFunction(library.nonsense, scalars=["data"]))
    assert np.isfinite(nonsense["force_n"]).all()


def test_a_function_of_c_is_felt_in_real_time(library):
    scene = palpa.Scene()
    scene.add("data", palpa.head_phantom())
    scene.add("mode", palpa.CFunction(library.syrup, scalars=["data"]))
    with palpa.live(scene, hand="sim:stroke", duration_s=0.3) as live:
        pass
    assert live.stop().header["complete"] is True


def test_what_is_no_function_of_c_is_refused(library):
    scene = palpa.Scene()
    scene.add("data", palpa.head_phantom())
    for wrong, error in ((len, TypeError), ("syrup", TypeError), (0, ValueError), (True, TypeError)):
        with pytest.raises(error, match="function"):
            scene.add("mode", palpa.CFunction(wrong))
    with pytest.raises(ValueError, match="at most 8 fields"):
        scene.add("mode", palpa.CFunction(library.syrup, scalars=["data"] * 9))
    with pytest.raises(palpa.SceneError, match="scalar"):
        scene.add("mode", palpa.CFunction(library.rail, vectors=["data"]))


def test_modes_of_a_plugin_are_classes(tmp_path):
    ridge = next(pathlib.Path(palpa.__file__).parents[2].glob("bin/examples/*ridge*.so"), None)
    if ridge is None:
        pytest.skip("the examples are not built")
    program = ("import palpa, sys\n(cls,) = palpa.load_plugin(sys.argv[1])\nassert cls is palpa.LabRidge, cls\n"
               "scene = palpa.Scene()\nscene.add('v', palpa.head_phantom())\nprint(cls.__doc__.splitlines()[0])\n")
    subprocess.run([sys.executable, "-c", program, ridge], check=True)
    with pytest.raises(palpa.LoadError, match="no such file"):
        palpa.load_plugin(tmp_path / "none.so")


class Wall(palpa.Mode):
    """Places given primitives, once the proxy is below the middle."""

    fields = ("field",)

    def __init__(self, kind, *arguments):
        self.field, self.kind, self.arguments = "data", kind, arguments

    def place(self, here, out):
        place = getattr(out, self.kind)
        place(0, *[argument(here) if callable(argument) else argument for argument in self.arguments])


def proxy(here):
    return here.proxy_m


nan = float("nan")
wrong_primitives = [
    (Wall("line", proxy, (0, 0, 2), 0.5), "direction is not of unit length"),
    (Wall("plane", proxy, (0, 0, 0), 0.5), "direction is not of unit length"),
    (Wall("directed", (1, 1, 0), 0.5), "direction is not of unit length"),
    (Wall("line", proxy, (nan, 0, 1), 0.5), "direction is not of unit length"),
    (Wall("point", (nan, 0, 0), 0.5), "position is not finite"),
    (Wall("point", proxy, nan), "strength is not finite"), (Wall("point", proxy, float("inf")), "strength is not finite"),
    (Wall("point", proxy, -0.5), "strength is negative"), (Wall("point", proxy, 0.5, -1.0), "drag is negative"),
    (Wall("point", proxy, 0.5, nan), "drag is not finite"),
    (Wall("point", lambda here: here.proxy_m + [0.001, 0, 0], 0.5, 1.0), "drag is placed away from the start"),
]


@pytest.mark.parametrize("mode, words", wrong_primitives)
def test_a_primitive_that_cannot_be_used_raises(mode, words):
    scene = palpa.Scene()
    scene.add("data", palpa.head_phantom())
    scene.add("lab", mode)
    for feel in (lambda: palpa.Session(scene).tick((0, 0, 0), 1e-3), lambda: palpa.Session(scene).ticks(path_of(5), 1e-3),
                 lambda: palpa.run(scene, path_of(20), 1e-3)):
        with pytest.raises(ValueError, match=f"mode 'lab': {words}"):
            feel()
    mode = type("Loose", (Wall,), {"strict": False})(mode.kind, *mode.arguments)
    loose = palpa.Scene()
    loose.add("data", palpa.head_phantom())
    loose.add("lab", mode)
    session = palpa.Session(loose)
    tick = session.tick((0, 0, 0), 1e-3)
    assert tick.dropped > 0 and any(words in str(value) for _, _, value in session.events())


def test_a_slot_is_used_once():
    class Twice(palpa.Mode):
        def place(self, here, out):
            out.point(3, here.proxy_m, 0.5)
            out.point(3, here.proxy_m, 0.5)

    with pytest.raises(ValueError, match="mode 'mode': slot is used twice"):
        felt(palpa.head_phantom(), Twice(), path_of(5))


def test_rows_of_c_that_do_not_fit_are_told(library):
    scene = palpa.Scene()
    scene.add("data", palpa.head_phantom())
    scene.add("lab", palpa.CFunction(library.nonsense, scalars=["data"]))
    words = f"mode 'lab': its function of C returned {1 << 30} rows; there is room for 16"
    with pytest.warns(palpa.PalpaWarning, match=words):
        palpa.Session(scene).tick((0, 0, 0), 1e-3)
    with pytest.warns(palpa.PalpaWarning, match=words):
        palpa.Session(scene).ticks(path_of(5), 1e-3)
    with pytest.warns(palpa.PalpaWarning, match=words):
        trace = palpa.run(scene, path_of(20), 1e-3)
    assert any("there is room for 16" in sentence for sentence in trace.warnings)
    with pytest.warns(palpa.PalpaWarning, match=words):
        with palpa.live(scene, hand="sim:press", duration_s=0.3) as live:
            while live.is_running:
                pass


def test_what_a_mode_asks_wrongly_is_told():
    class Asks(palpa.Mode):
        fields = ("field",)

        def __init__(self, field, place):
            self.field, self.asks = field, place

        def place(self, here, out):
            self.asks(here, out)

    for asks, error, words in (
            (lambda here, out: here.vector("head"), TypeError, "field 'head' holds scalars; 'scalar' samples it"),
            (lambda here, out: out.point(-1, here.proxy_m, 1), ValueError, "'slot' is -1; it lies between 0 and 65535"),
            (lambda here, out: out.directed(70000, (0, 0, 1), 1), ValueError, "'slot' is 70000"),
            (lambda here, out: setattr(here, "proxy_m", (0, 0, 0)), AttributeError, "ModeContext: 'proxy_m' cannot be set"),
            (lambda here, out: setattr(out, "strict", False), AttributeError, "PrimitiveSink: no attribute 'strict'"),
            (lambda here, out: out.point(0, np.ma.array(here.proxy_m, mask=[1, 0, 0]), 1), ValueError, "position is not finite")):
        scene = palpa.Scene()
        scene.add("head", palpa.head_phantom())
        scene.add("lab", Asks("head", asks))
        with pytest.raises(error, match=words):
            palpa.Session(scene).tick((0, 0, 0), 1e-3)
    flow = palpa.Scene()
    flow.add("flow", palpa.lamb_oseen_vortex())
    flow.add("lab", Asks("flow", lambda here, out: here.scalar("flow")))
    with pytest.raises(TypeError, match="field 'flow' holds vectors; 'vector' samples it"):
        palpa.Session(flow).tick((0, 0, 0), 1e-3)


def test_fields_are_names():
    for fields, given, words in (("field", dict(field="head"), "'fields' takes names of fields"), (("field",), {}, "it is not there"),
                                 (("field",), dict(field=None), "it is NoneType")):
        mode = type("Lab", (palpa.Mode,), dict(fields=fields, place=lambda self, here, out: None, **given))()
        scene = palpa.Scene()
        scene.add("head", palpa.head_phantom())
        with pytest.raises(TypeError, match=words):
            scene.add("lab", mode)
    with pytest.raises(TypeError, match="'scalars' takes names of fields"):
        palpa.CFunction(1, scalars="head")


# ---- levels, memory, friction ----


class Shell(palpa.Mode):
    """One level of palpa.SurfaceAndFriction, in Python."""

    fields, held_levels, strengths = ("field",), ("level",), ("strength_n",)
    memory = {"held": 0.0, "pressed_to": 0.0}

    def __init__(self, field, level, strength_n, friction_coefficient=0.0, stiffness_n_per_m=None):
        self.field, self.level, self.strength_n = field, level, strength_n
        self.friction_coefficient, self.stiffness_n_per_m = friction_coefficient, stiffness_n_per_m

    def place(self, here, memory, out):
        at_m = here.footing_m(0)
        sample = here.scalar(self.field, at_m)
        slope = np.linalg.norm(sample.gradient)
        if not memory["held"] or not sample.inside or slope == 0:
            return
        uphill, level = sample.gradient / slope, here.level(self.field, self.level, memory["pressed_to"])
        step_m = np.clip((level.pressed_to - sample.value) / slope, -here.finest_m, here.finest_m)
        strength_n = here.newtons(self.strength_n, level)
        if self.stiffness_n_per_m is None:
            out.plane(0, at_m + step_m * uphill, -uphill, strength_n, level=level)
        else:
            out.elastic_plane(0, at_m + step_m * uphill, -uphill, strength_n, self.stiffness_n_per_m, level=level)
        if self.friction_coefficient:
            out.friction(1, 0, here.proxy_m, self.friction_coefficient)

    def on_step_accepted(self, step, memory):
        if not step.here.scalar(self.field).inside:
            memory["held"] = 0
            return
        if memory["held"]:
            state = step.state(0)
            if state == "slip" and not step.yields(0):
                memory["held"] = 0
            elif state == "slip" or state == "off" and memory["pressed_to"] != self.level:
                at = step.here.scalar(self.field, step.here.footing_m(0))
                memory["pressed_to"] = max(self.level, at.value)
        for field, value, up in step.crossings:
            if (field, value) == (self.field, self.level):
                memory.update(held=float(up), pressed_to=self.level)


def presses(n=2500):
    """Into the ball and across, deep enough to break through, out and in again."""
    t = np.linspace(0, 1, n)
    return np.column_stack([0.02 * np.sin(9 * t), 0.01 * np.cos(11 * t), 0.085 + 0.02 * np.cos(25 * t)])


by_value = palpa.Strength(of="magnitude(flow)", points=[(0, 1), (0.3, 2)], outside=2)


@pytest.mark.parametrize("more", [dict(), dict(friction_coefficient=0.3), dict(stiffness_n_per_m=900.0)])
@pytest.mark.parametrize("strength_n", [2.0, by_value])
def test_a_level_in_python_is_felt_as_the_one_in_cpp(strength_n, more):
    def felt_ball(mode):
        scene = palpa.Scene(stiffness_n_per_m=400)
        scene.add("ball", palpa.sphere_field())
        scene.add("flow", palpa.lamb_oseen_vortex())
        scene.add("wall", mode)
        scene.workspace.scale, scene.workspace.center = 0.6, (0, 0, 0)
        return palpa.Session(scene).ticks(presses(), 1e-3)

    ours = felt_ball(Shell("ball", 0.0, strength_n, **more))
    theirs = felt_ball(palpa.SurfaceAndFriction(field="ball", levels=[dict(value=0.0, strength_n=strength_n, **more)]))
    kinds = [kind for _, kind, _, _ in theirs.events]
    assert "break_through" in kinds and kinds.count("onset") > 1 and ours.events == theirs.events
    same(ours, theirs, 1e-9)
    np.testing.assert_allclose(ours["force_n"], theirs["force_n"], atol=1e-6)
    if not more and strength_n == 2.0:
        assert np.linalg.norm(ours["force_n"], axis=1).max() == pytest.approx(2.0, abs=0.02)


def test_the_memory_of_a_mode_is_of_its_session():
    class Counts(palpa.Mode):
        memory = {"steps": 2.0}
        seen = []

        def place(self, here, memory, out):
            memory["steps"] = -1.0  # of no effect

        def on_step_accepted(self, step, memory):
            memory["steps"] += 1
            self.seen.append(memory["steps"])

    scene = palpa.Scene()
    scene.add("head", palpa.head_phantom())
    scene.add("counts", Counts())
    session, other = palpa.Session(scene), palpa.Session(scene)
    session.ticks(path_of(50), 1e-3)
    first = list(Counts.seen)
    assert first == [3.0 + n for n in range(len(first))] and len(first) >= 49
    other.copy_state_from(session)
    for each in (session, other):
        Counts.seen.clear()
        each.tick((0, 0, 0.01), 1e-3)
        assert Counts.seen[0] == first[-1] + 1, "the memory is copied, not shared"
    session.reset()
    Counts.seen.clear()
    session.tick((0, 0, 0), 1e-3), session.tick((0, 0, 0.001), 1e-3)
    assert Counts.seen[0] == 3.0


def test_what_a_mode_with_levels_lacks_is_told():
    def lab(**members):
        return type("Lab", (palpa.Mode,), {"place": lambda self, *_: None, **members})()

    def accept(self, step, memory):
        memory["hled"] = 1.0

    for mode, error, words in (
            (lab(held_levels=("level",)), TypeError, "Lab: 'held_levels' has 'level', an attribute with a number or several; it is not there"),
            (lab(held_levels=("level",), level="high"), TypeError, "it is str"),
            (lab(held_levels=("level",), level=[1.0, 2.0]), TypeError, "'fields' lists it, too"),
            (lab(memory={"held": 0.0}), TypeError, "changed by a method 'on_step_accepted"),
            (lab(on_step_accepted=accept), TypeError, "'memory' lists its numbers"),
            (lab(memory={f"n{n}": 0.0 for n in range(32)}, on_step_accepted=accept), ValueError, "room for 31 numbers, not 32")):
        with pytest.raises(error, match=words):
            felt(palpa.head_phantom(), mode, path_of(5))
    with pytest.raises(KeyError, match="mode 'mode': no 'hled' in its memory; did you mean 'held'"):
        felt(palpa.head_phantom(), lab(memory={"held": 0.0}, on_step_accepted=accept), path_of(5))
    with pytest.raises(KeyError, match="names no strength like this one"):
        felt(palpa.head_phantom(), lab(place=lambda self, here, out: here.newtons(by_value)), path_of(5))
