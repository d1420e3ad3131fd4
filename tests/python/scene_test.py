"""Scenes, modes and their parameters: names, defaults and errors as in C++ and scene files."""

import copy
import inspect
import json
import pickle
import pydoc
import re
import subprocess

import numpy as np
import pytest

import palpa


def head_scene():
    scene = palpa.Scene(stiffness_n_per_m=400)
    head = scene.add("head", palpa.head_phantom())
    scene.add("skin", palpa.SurfaceAndFriction(field=head, levels=[dict(value=-300, strength_n=0.8, friction_n=0.1)]))
    return scene


def test_every_mode_of_the_program_is_a_class_with_its_parameters(palpa_program):
    listed = subprocess.run([palpa_program, "modes"], capture_output=True, text=True, check=True).stdout
    types = [line.split()[0] for line in listed.splitlines() if line.startswith("  ")]
    assert "surface_and_friction" in types and len(types) >= 10
    for mode_type in types:
        cls = getattr(palpa, "".join(word.capitalize() for word in mode_type.split("_")))
        text = subprocess.run([palpa_program, "modes", mode_type], capture_output=True, text=True, check=True).stdout
        own = text.split("\n\n")[1]
        for line in own.splitlines():
            key = line.split()[0]
            assert key in cls._attributes or key + "s" in cls._attributes, (mode_type, key)


def test_help_reads_like_documentation():
    text = pydoc.render_doc(palpa.Follow, renderer=pydoc.plaintext)
    assert "A rail along the field: free along it, held across it." in text
    assert "strength_n : float | Strength" in text
    assert "force that holds the hand on the line; above it the hand slides across" in text
    assert "drag_ns_per_m : float" in text and "number [N·s/m], between 0 and 100" in text
    assert "strength_n=0.5" in str(inspect.signature(palpa.Follow))


def test_parameters_are_attributes():
    follow = palpa.Follow(field="flow", strength_n=0.7)
    assert (follow.field, follow.strength_n, follow.drag_ns_per_m) == ("flow", 0.7, 0.0)
    follow.drag_ns_per_m = np.float32(2)
    assert follow.drag_ns_per_m == 2.0
    by_value = palpa.Strength(of="magnitude(flow)", points=[(0, 0.1), (1, 2)], outside=0.5)
    follow.strength_n = by_value
    assert follow.strength_n == by_value and follow.strength_n.points == ((0.0, 0.1), (1.0, 2.0))
    assert repr(palpa.Follow(field="flow", strength_n=0.7)) == "Follow(field='flow', strength_n=0.7)"
    assert palpa.Follow(field="flow") == palpa.Follow(field="flow") != palpa.Follow(field="other")
    assert copy.deepcopy(follow) == follow and pickle.loads(pickle.dumps(palpa.Follow(field="a"))) == palpa.Follow(field="a")


def test_lists_hold_items_that_change_with_their_mode():
    level = palpa.SurfaceAndFriction.Level(value=300, strength_n=4)
    assert level.friction_n is None
    mode = palpa.SurfaceAndFriction(field="head", friction_n=0.2, levels=[level, dict(value=-300, friction_n=0.1)])
    assert [each.value for each in mode.levels] == [300, -300]
    mode.levels[1].strength_n = 0.5
    assert mode.levels[1].strength_n == 0.5 and mode.levels[1].friction_n == 0.1
    mode.levels[1].friction_n = None
    assert mode.levels[1].friction_n is None
    mode.levels = [dict(value=7)]
    assert len(mode.levels) == 1 and mode.levels[0].value == 7 and mode.friction_n == 0.2, "the others keep their values"


@pytest.mark.parametrize("make, error, words", [
    (lambda: palpa.Follow(strenght_n=1), TypeError, "Follow: no parameter 'strenght_n'; did you mean 'strength_n'?"),
    (lambda: palpa.Follow(strength_n="much"), TypeError, "Follow: 'strength_n' takes float | Strength, not str"),
    (lambda: palpa.Follow(strength_n=True), TypeError, "not bool"),
    (lambda: palpa.Follow(field=3), TypeError, "'field' takes str, not int"),
    (lambda: palpa.GradientForce(field="f", towards="hihg"), ValueError, "no 'towards' 'hihg'; did you mean 'high'?"),
    (lambda: palpa.VortexForce(field="f", background=(1, 2)), ValueError, "'background' has 2 numbers; it takes 3"),
    (lambda: palpa.SurfaceAndFriction(levels=[dict(valeu=3)]), AttributeError, "no parameter 'valeu'; did you mean 'value'?"),
    (lambda: palpa.SurfaceAndFriction(levels=[3]), TypeError, "levels" [:5]),
    (lambda: palpa.Scene(stifness_n_per_m=3), TypeError, "Scene: no parameter 'stifness_n_per_m'; did you mean 'stiffness_n_per_m'?"),
    (lambda: palpa.Strength(of="f", points=[(1, 0), (0, 1)]), ValueError, ""),
    (lambda: palpa.Scene().add("a", 3), TypeError, "'a' is to be a palpa.Volume or a palpa.Mode, not int"),
    (lambda: palpa.Scene().add("a b", palpa.head_phantom()), palpa.SceneError, "a b"),
    (lambda: palpa.load_scene("/nowhere/x.toml"), palpa.SceneError, "/nowhere/x.toml"),
    (lambda: palpa.lamb_oseen_vortex(core_radius_m=-1), ValueError, ""),
    (lambda: setattr(palpa.Follow(), "strenght_n", 1), AttributeError, "did you mean 'strength_n'?"),
])
def test_what_is_wrong_is_one_line(make, error, words):
    with pytest.raises(error) as told:
        make()
    assert words in str(told.value) and "\n" not in str(told.value) and str(told.value)


def test_errors_are_those_of_the_library():
    scene = palpa.Scene()
    scene.add("flow", palpa.lamb_oseen_vortex())
    with pytest.raises(palpa.SceneError, match=r"no volume 'flwo'; did you mean 'flow'\?"):
        scene.add("rail", palpa.Follow(field="flwo"))
    with pytest.raises(palpa.SceneError, match="between 0 and 1000"):
        scene.add("rail", palpa.Follow(field="flow", strength_n=-1))
    scene.add("rail", palpa.Follow(field="flow"))
    with pytest.raises(palpa.SceneError, match="rail"):
        scene.add("rail", palpa.Follow(field="flow"))
    assert issubclass(palpa.SceneError, palpa.LoadError) and issubclass(palpa.LoadError, ValueError)


def test_what_is_changed_in_a_scene_is_changed_there():
    scene = head_scene()
    skin = scene.modes["skin"]
    skin.mode.levels[0].friction_n = 0.3
    skin.enabled = False
    skin.masks = [palpa.Mask(of="head", points=[(-1000, 0), (0, 1)])]
    scene.coupling.stiffness_n_per_m = 500
    scene.workspace.towards_user = "anterior"
    scene.workspace.center = (0, 0, 0.01)
    assert scene.workspace.center == (0, 0, 0.01)
    scene.workspace.center = "head"
    assert scene.workspace.center == "head" and scene.workspace.towards_user == "anterior"
    scene.workspace.scale = 2
    scene.workspace.scale = None
    assert scene.workspace.scale is None
    scene.time.play = "loop"
    text = scene.to_toml()
    for line in ("friction_n = 0.3", "enabled = false", "mask = [{of = \"head\"", "stiffness_n_per_m = 500", "center = \"head\"", "play = \"loop\""):
        assert line in text
    with pytest.raises(TypeError):
        scene.modes["new"] = skin
    other = scene.copy()
    other.modes["skin"].enabled = True
    assert not scene.modes["skin"].enabled and other != scene and scene == scene.copy()
    held = scene.modes["skin"]
    scene.remove_mode("skin")
    with pytest.raises(KeyError, match="no longer in its scene"):
        held.enabled


def test_defaults_are_those_of_a_scene_file(tmp_path):
    (tmp_path / "a.toml").write_text('palpa = 1\n[volume.v]\nanalytic = "lamb_oseen_vortex"\n[[mode]]\nname = "r"\n'
                                     'type = "follow"\nfield = "v"\n')
    loaded = palpa.load_scene(tmp_path / "a.toml")
    made = palpa.Scene()
    made.add("v", palpa.lamb_oseen_vortex())
    made.add("r", palpa.Follow(field="v"))
    ours = [line for line in made.to_toml().splitlines() if not line.startswith("#")]
    theirs = [line for line in loaded.to_toml().splitlines() if not line.startswith("analytic")]
    assert ours == theirs
    assert loaded.modes["r"].mode == palpa.Follow(field="v") and loaded.coupling == palpa.CouplingOptions()


def test_sets_and_warnings(tmp_path):
    (tmp_path / "a.toml").write_text('palpa = 1\n[time]\nplay = "loop"\n[volume.v]\nanalytic = "lamb_oseen_vortex"\n[[mode]]\n'
                                     'name = "r"\ntype = "follow"\nfield = "v"\n')
    with pytest.warns(palpa.PalpaWarning, match="nothing in the scene changes with time"):
        scene = palpa.load_scene(tmp_path / "a.toml", sets={"mode.r.strength_n": 0.25, "coupling.stiffness_n_per_m": 700})
    assert scene.modes["r"].mode.strength_n == 0.25 and scene.coupling.stiffness_n_per_m == 700


def test_a_file_is_read_as_the_program_reads_it(tmp_path, palpa_program, needs_reader):
    (tmp_path / "eight.nrrd").write_bytes(b"NRRD0004\ntype: short\ndimension: 3\nsizes: 2 3 4\nspacings: 1 2 3\nencoding: raw\n"
                                          b"endian: little\n\n" + np.arange(24, dtype="<i2").tobytes())
    volume = palpa.read_volume(tmp_path / "eight.nrrd", length_unit="cm")
    told = json.loads(subprocess.run([palpa_program, "info", tmp_path / "eight.nrrd", "--json"], capture_output=True, check=True).stdout)
    (field,) = volume.fields.values()
    assert field.value_ranges == [(told["fields"][0]["min"], told["fields"][0]["max"])]
    assert volume.format == told["format"] and volume.length_unit == "cm"
    with pytest.raises(TypeError, match="'frame' takes int"):
        palpa.read_volume(tmp_path / "eight.nrrd", frame="first")
    with pytest.raises(palpa.LoadError, match="nothing.nrrd"):
        palpa.read_volume(tmp_path / "nothing.nrrd")


def test_bare_numbers_need_no_reader(tmp_path):
    values = np.arange(60, dtype="<f4").reshape(3, 4, 5)
    (tmp_path / "a.raw").write_bytes(values.tobytes())
    volume = palpa.read_volume(tmp_path / "a.raw", type="float32", dims=(5, 4, 3), spacing_m=(0.1, 0.2, 0.3))
    (field,) = volume.fields.values()
    assert field.value_ranges == [(0.0, 59.0)]
    np.testing.assert_allclose(field(np.array([0.4, 0.6, 0.6]))[0], 59.0)


def test_laws_are_named():
    assert palpa.laws()[0] == "exact"
    scene = head_scene()
    scene.law = "no-proxy"
    assert "no-proxy" in scene.to_toml()
    with pytest.raises(palpa.SceneError, match="no law 'nonsense'"):
        scene.law = "nonsense"
    assert scene.law == "no-proxy"


def test_an_attribute_that_there_is_not_is_told():
    scene = head_scene()
    for thing, name, words in (
            (scene, "stifness_n_per_m", "Scene: no attribute 'stifness_n_per_m'; did you mean 'stiffness_n_per_m'?"),
            (scene, "scale", "Scene: no attribute 'scale'; did you mean 'workspace.scale'?"),
            (scene, "levels", "no attribute 'levels'"), (scene, "lwa", "did you mean 'law'?"),
            (scene.modes["skin"], "enable", "SceneMode: no attribute 'enable'; did you mean 'enabled'?"),
            (scene.modes["skin"], "friction_n", "did you mean 'mode.friction_n'?"),
            (scene.workspace, "scael", "did you mean 'scale'?"), (scene.coupling, "max_force", "did you mean 'max_force_n'?")):
        with pytest.raises(AttributeError) as told:
            setattr(thing, name, 1)
        assert words in str(told.value) and "\n" not in str(told.value)
        with pytest.raises(AttributeError):
            getattr(thing, name)


def test_the_keys_of_the_coupling_are_attributes_that_work():
    scene = palpa.Scene(stiffness_n_per_m=500)
    for name in palpa.CouplingOptions._attributes:
        value = getattr(scene.coupling, name)
        if isinstance(value, float) and value > 0:
            setattr(scene, name, 0.5 * value)
            assert getattr(scene, name) == getattr(scene.coupling, name) == 0.5 * value
    scene.stiffness_n_per_m, scene.max_force_n, scene.damping_ns_per_m = 2000, 1, 0
    assert "stiffness_n_per_m = 2000" in scene.to_toml() and "max_force_n = 1" in scene.to_toml()
    scene.add("floor", palpa.plane_field())
    scene.workspace.scale, scene.workspace.center = 1, (0, 0, 0)
    scene.add("hard", palpa.SurfaceAndFriction(field="floor", levels=[dict(value=0, strength_n=100)]))
    session = palpa.Session(scene)
    session.tick((0, 0, 0.001), 1e-3)
    np.testing.assert_allclose(session.tick((0, 0, -0.001), 1e-3).force_n, (0, 0, 2.0), atol=1e-9)


@pytest.mark.parametrize("thing, name, value", [
    (lambda: palpa.Scene(), "stiffness_n_per_m", -1), (lambda: palpa.Scene(), "stiffness_n_per_m", float("nan")),
    (lambda: palpa.Scene(), "max_force_n", float("inf")), (lambda: palpa.Scene(), "damping_ns_per_m", -1e-9),
    (lambda: palpa.Scene(), "law", "god-object"), (lambda: palpa.Scene().workspace, "scale", 0),
    (lambda: palpa.Scene().workspace, "scale", float("nan")), (lambda: palpa.Scene().workspace, "towards_user", "sideways"),
    (lambda: palpa.Follow(), "strength_n", -1), (lambda: palpa.Follow(), "strength_n", float("nan")),
    (lambda: palpa.Follow(), "strength_n", palpa.Strength(of="v", points=[(0, -1)])),
    (lambda: palpa.Follow(), "drag_ns_per_m", 1e6), (lambda: palpa.SurfaceAndFriction.Level(), "strength_n", -2),
    (lambda: palpa.SurfaceAndFriction(), "levels", [dict(value=0, strength_n=-2)]), (lambda: palpa.Scene().time, "speed", float("inf")),
])
def test_a_value_that_a_parameter_cannot_have_is_refused_where_it_is_set(thing, name, value):
    thing = thing()
    before = getattr(thing, name)
    with pytest.raises(ValueError) as told:
        setattr(thing, name, value)
    assert "\n" not in str(told.value) and ";" in str(told.value)
    after = getattr(thing, name)
    assert after == before or (after != after and before != before), "it keeps the one that it had"


def test_numbers_of_numpy_are_numbers():
    scene = palpa.Scene(stiffness_n_per_m=np.float32(512))
    scene.max_force_n = np.int64(2)
    scene.workspace.scale = np.float16(2)
    scene.add("v", palpa.lamb_oseen_vortex())
    scene.add("r", palpa.Follow(field="v", strength_n=np.array(0.5)), enabled=np.bool_(True))
    assert (scene.stiffness_n_per_m, scene.max_force_n, scene.workspace.scale) == (512, 2, 2)
    tick = palpa.Session(scene).tick(np.zeros(3, np.float32), np.float32(1e-3))
    assert np.isfinite(tick.force_n).all()
    assert len(palpa.Session(scene).ticks(np.zeros((4, 3), np.float32), np.array(1e-3))) == 4


def test_names_that_there_are_not_are_told():
    scene = head_scene()
    for things, words in ((scene.modes, "did you mean 'skin'?"), (palpa.Session(scene).modes(), "did you mean 'skin'?"),
                          (scene.volumes, "no volume 'skinn'; there are: head")):
        with pytest.raises(KeyError) as told:
            things["skinn"]
        assert words in str(told.value)
    assert "skin" in scene.modes and list(scene.modes) == ["skin"] and scene.modes.get("no") is None
    with pytest.raises(TypeError, match="'masks' takes a list"):
        scene.modes["skin"].masks = palpa.Mask(of="head", points=[(0, 1)])


def test_things_show_what_they_are():
    scene = head_scene()
    session = palpa.Session(scene)
    tick = session.tick((0, 0.02, 0.05), 1e-3)
    for thing, words in ((scene.volumes["head"], "formula"), (scene.field("head"), "Field('"), (session, "skin"),
                         (tick.energy, "stored_j="), (session.modes()["skin"], "force_n="),
                         (palpa.DeviceLimits(max_force_n=2), "max_force_n=2")):
        assert words in repr(thing) and " object at 0x" not in repr(thing), repr(thing)


def test_every_class_shows_what_it_is(tmp_path):
    """No object of the package is shown as an address."""

    class Own(palpa.Mode):
        def place(self, here, out):
            shown.extend([here, out, here.scalar("head"), here.vector("flow"), here.level("head", 0.0)])

        fields = ("field", "flow")
        field, flow = "head", "flow"

    class Remembers(palpa.Mode):
        memory = {"n": 0.0}

        def place(self, here, memory, out):
            pass

        def on_step_accepted(self, step, memory):
            shown.append(repr(step))

    class Dummy(palpa.Device):
        limits = palpa.DeviceLimits(max_force_n=1)

    shown, scene = [], head_scene()
    scene.add("flow", palpa.lamb_oseen_vortex())
    scene.add("own", Own())
    scene.add("remembers", Remembers())
    session = palpa.Session(scene)
    rows = session.ticks(np.zeros((3, 3)), 1e-3)
    assert any("StepResult(crossings=" in str(thing) for thing in shown), "while it runs"
    scene.remove_mode("own")
    scene.remove_mode("remembers")
    guarded = palpa.GuardedSession(scene, palpa.DeviceLimits(max_force_n=2))
    things = [*shown, scene, scene.coupling, scene.workspace, scene.time, scene.tool, scene.volumes, scene.volumes["head"], scene.modes,
              scene.modes["skin"], scene.modes["skin"].mode, scene.modes["skin"].mode.levels, scene.field("head"), session, rows,
              rows.statuses, rows.mode_force_n, rows.events, session.modes(), session.tick((0, 0, 0), 1e-3).energy, guarded,
              guarded.tick((0, 0, 0), 1e-3, valid=True, fault=False), palpa.DeviceState((0, 0, 0)), palpa.DeviceLimits(max_force_n=2),
              palpa.MouseHand(), palpa.Strength(of="head", points=[(0, 1)]), palpa.Mask(of="head", points=[(0, 1)]), Own(), Dummy(),
              palpa.CFunction(1 << 20), palpa.TickStatus.resting, palpa.compare_laws(scene, np.zeros((3, 3)), 1e-3, ["no-proxy"])]
    both = scene.copy()
    both.add_hand("thumb", tool=palpa.ToolOptions(shape="ball", radius_m=0.01))
    things += [both.hands, both.hands["thumb"]]
    with palpa.run(scene, np.zeros((3, 3)), 1e-3) as trace:
        things += [trace, trace.ticks, trace.compare(trace)]
    with palpa.live(scene, hand="sim:press", duration_s=0.05) as live:
        things.append(live)
    for thing in things:
        assert " object at 0x" not in repr(thing), repr(thing)
    seen = {type(thing) for thing in things} | {Own.__mro__[1], Dummy.__mro__[1], palpa.HeldLevel}
    left = [name for name in palpa.__all__ if isinstance(getattr(palpa, name), type) and not issubclass(getattr(palpa, name), (Exception, palpa.Mode))
            and getattr(palpa, name) not in seen]
    assert set(left) <= {"FeltActors", "MousePointer", "Tick", "ModeForce", "StepResult", "LoadError", "SceneError", "PalpaWarning", "Replay", "Store"}, left


def fresh_python(code, cwd=None, **environment):
    import os
    import subprocess
    import sys

    return subprocess.run([sys.executable, *environment.pop("arguments", []), "-c", code], capture_output=True, text=True, cwd=cwd,
                          env={**os.environ, **environment})


def test_an_import_that_cannot_work_says_why(tmp_path):
    import pathlib
    import shutil
    import sys

    package = pathlib.Path(palpa.__file__).parent
    told = fresh_python(f"import sys\nsys.path.insert(0, {str(package.parent)!r})\nsys.modules['numpy'] = None\nimport palpa")
    assert told.returncode != 0 and "numpy" in told.stderr.splitlines()[-1]
    # Without site-packages there is no numpy.
    told = fresh_python(f"import sys\nsys.path.insert(0, {str(package.parent)!r})\nimport palpa", arguments=["-S", "-E"])
    if "numpy" not in sys.builtin_module_names and told.returncode != 0:
        assert told.stderr.splitlines()[-1].startswith("ImportError: palpa needs numpy")
    # Built for another CPython.
    shutil.copytree(package, tmp_path / "palpa")
    (module,) = (tmp_path / "palpa").glob("_palpa*.so")
    module.rename(module.with_name(re.sub(r"cpython-3\d+", "cpython-399", module.name)))
    told = fresh_python("import palpa", PYTHONPATH=str(tmp_path))
    last = told.stderr.splitlines()[-1]
    assert told.returncode != 0 and "was built for CPython 3.99" in last and f"this is cpython 3.{sys.version_info[1]}" in last
    for each in (tmp_path / "palpa").glob("_palpa*.so"):
        each.unlink()
    assert "is not built" in fresh_python("import palpa", PYTHONPATH=str(tmp_path)).stderr.splitlines()[-1]


def test_a_call_that_fits_nothing_is_told_in_a_sentence():
    session = palpa.Session(head_scene())
    for call, words in (
            (lambda: palpa.Session(), "Session: 'scene' is missing; it is Session(scene, encoder_step_m=0.0)"),
            (lambda: palpa.Session(3), "Session: 'scene' takes a palpa.Scene, not int"),
            (lambda: session.tick((0, 0, 0)), "Session.tick: 'dt_s' is missing"),
            (lambda: session.tick((0, 0, 0), "1 ms"), "Session.tick: 'dt_s' takes a number, not str"),
            (lambda: session.tick((0, 0, 0), 1e-3, velcity_m_per_s=None), "no parameter 'velcity_m_per_s'; did you mean 'velocity_m_per_s'?"),
            (lambda: session.reset(1), "Session.reset: takes 0 arguments, not 1"),
            (lambda: palpa.sphere_field(0.03), "sphere_field: 'radius_m' is said by its name; it is sphere_field(*, radius_m=0.05)"),
            (lambda: palpa.sphere_field(radius_m="x"), "sphere_field: 'radius_m' takes a number, not str"),
            (lambda: palpa.Strength(2.0), "Strength: 'of' is said by its name"),
            (lambda: palpa.Mask(points=[(0, 1)]), "Mask: 'of' is missing"),
            (lambda: palpa.Tick(), "Tick"), (lambda: setattr(head_scene(), "title", 3), "Scene.title takes a text, not int"),
            (lambda: head_scene().remove_mode(), "Scene.remove_mode: 'name' is missing"),
            (lambda: palpa.MouseHand(radius="x"), "no parameter 'radius'; did you mean 'radius_m'?"),
            (lambda: palpa.live(session), "'scene' takes a palpa.Scene, not Session"),
            (lambda: palpa.GuardedSession(head_scene()), "GuardedSession: 'limits' is missing"),
            (lambda: palpa.GuardedSession(head_scene(), 3), "GuardedSession: 'limits' takes a palpa.DeviceLimits, not int")):
        with pytest.raises(TypeError) as told:
            call()
        assert words in str(told.value) and "\n" not in str(told.value) and "incompatible" not in str(told.value), str(told.value)
    assert np.isfinite(session.tick((0, 0, 0), np.float32(1e-3)).force_n).all() and session.tick((0, 0, 0), 1).status is not None
    with pytest.raises(TypeError, match="'position_m' takes three numbers"):
        session.tick(None, 1e-3)
    assert "TickRow" not in pydoc.render_doc(palpa.Session) and "anonymous" not in pydoc.render_doc(palpa.Session)


def test_nothing_is_set_that_changes_nothing():
    scene = head_scene()
    mode = palpa.SurfaceAndFriction(field="head")
    function = palpa.CFunction(1)
    for thing, names in ((scene, ("check", "add", "copy")), (scene.modes["skin"], ("mode", "name")), (scene, ("modes", "volumes")),
                         (mode, ("fields", "strict", "place", "Level")), (function, ("scalar", "strict", "fields", "place")),
                         (palpa.Session(scene), ("scene", "encoder_step_m", "tick")), (scene.volumes["head"], ("spacing_m", "fields")),
                         (scene.field("head"), ("filter", "unit")), (palpa.Strength(of="a", points=[(0, 1)]), ("points", "outsde")),
                         (palpa.Session(scene).tick((0, 0, 0), 1e-3), ("force_n", "forces_n"))):
        for name in names:
            with pytest.raises(AttributeError) as told:
                setattr(thing, name, 1)
            assert "\n" not in str(told.value), name
    with pytest.raises(AttributeError, match=r"'check' is a method, which cannot be set; call it: check\(\)"):
        scene.check = True
    assert scene.check() == [] and scene.needs == () and not hasattr(scene.needs, "append")
    scene.needs = ["lab.ridge"]
    assert scene.needs == ("lab.ridge",)
    with pytest.raises(TypeError, match="Scene: 'coupling' takes a palpa.CouplingOptions, not dict"):
        scene.coupling = dict(stiffness_n_per_m=3)
    with pytest.raises(TypeError, match="Mine: SurfaceAndFriction is made in C.*derives from palpa.Mode"):
        class Mine(palpa.SurfaceAndFriction):
            def place(self, here, out):
                pass


def test_the_sources_in_the_checkout_stand_in_nobodys_way(tmp_path):
    import pathlib
    import shutil

    root, package = pathlib.Path(__file__).resolve().parents[2], pathlib.Path(palpa.__file__).resolve().parent
    shows = "import palpa, pathlib; print(pathlib.Path(palpa.__file__).resolve().parent, palpa.Scene())"
    for path in (f"{root}:{package.parent}", f"{package.parent}:{root}"):
        told = fresh_python(shows, PYTHONPATH=path)
        assert told.stdout == f"{package} Scene(volumes=[], modes=[])\n", told.stderr
    # A checkout with a build folder, and one without.
    (tmp_path / "palpa").mkdir()
    shutil.copy(root / "palpa/__init__.py", tmp_path / "palpa")
    for cwd in (tmp_path, root):  # root: another checkout
        told = fresh_python(shows, cwd=cwd, PYTHONPATH=str(tmp_path))
        assert told.returncode != 0
        assert "holds the sources in C++, and the Python package is not built; cmake" in told.stderr.splitlines()[-1]
    (tmp_path / "build").mkdir()
    (tmp_path / "build/any").symlink_to(package.parents[1])
    told = fresh_python(shows, PYTHONPATH=str(tmp_path))
    assert told.stdout.startswith(str(package)), told.stderr
    told = fresh_python("import palpa", PYTHONPATH=f"{root / 'python'}")
    assert "holds the package's sources" in told.stderr.splitlines()[-1]


def test_a_numpy_that_the_module_cannot_read_is_refused():
    palpa._check_numpy("1.24.2", "2.10.3"), palpa._check_numpy("2.1.0", "2.12.0"), palpa._check_numpy("2.3.1", "3.0.1")
    with pytest.raises(ImportError, match="built with pybind11 2.10.3, which reads arrays of numpy 1 only, and this is numpy 2.1.0"):
        palpa._check_numpy("2.1.0", "2.10.3")


def test_sets_take_what_a_scene_file_takes(tmp_path):
    (tmp_path / "a.toml").write_text('palpa = 1\n[volume.v]\nanalytic = "lamb_oseen_vortex"\n[[mode]]\nname = "r"\ntype = "follow"\nfield = "v"\n')
    scene = palpa.load_scene(tmp_path / "a.toml", sets={
        "coupling.stiffness_n_per_m": np.float32(256), "coupling.max_force_n": np.int64(2), "workspace.center": np.array([0.1, 0, 0]),
        "mode.r.enabled": np.bool_(False), "workspace.scale": 2})
    assert (scene.stiffness_n_per_m, scene.max_force_n, scene.workspace.scale) == (256, 2, 2)
    assert scene.workspace.center == (0.1, 0, 0) and not scene.modes["r"].enabled
    with pytest.raises(TypeError, match="'sets': 'workspace.scale' takes a number, .* not NoneType"):
        palpa.load_scene(tmp_path / "a.toml", sets={"workspace.scale": None})
