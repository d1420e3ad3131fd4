"""Live scenes: changed and watched at run time, and ended in any case."""

import subprocess
import sys
import threading
import time
import types

import numpy as np
import pytest

import palpa
from scene_test import head_scene


def wait_for(condition, limit_s=20):
    end = time.monotonic() + limit_s
    while not condition():
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.01)


def test_a_scene_is_changed_while_it_is_felt():
    with palpa.live(head_scene(), hand="sim:stroke", duration_s=60) as live:
        wait_for(lambda: live.latest()["tick"] > 200)
        scene = live.scene
        scene.modes["skin"].mode.levels[0].friction_n = 0.4
        assert live.scene.modes["skin"].mode.levels[0].friction_n == 0.1, "a copy, until it is set"
        live.scene = scene
        wait_for(lambda: live.statistics()["scenes"] >= 1)
        assert live.scene.modes["skin"].mode.levels[0].friction_n == 0.4
        with pytest.raises(palpa.SceneError, match="no volume 'nonsense'"):
            scene.modes["skin"].mode.field = "nonsense"  # where it is set: a scene fits together at any time
        live.scene = scene
        live.panic()
        wait_for(lambda: live.latest()["guard"] in ("off", "falling"))
        live.resume()
        assert live.is_running
    assert not live.is_running
    trace, counted = live.stop(), live.statistics()
    assert trace is live.stop() and trace.header["complete"] is True
    assert len(trace.ticks) + counted["unrecorded"] == counted["ticks"], "a row for each tick"
    assert trace.ticks["tick"][-1] + 1 == counted["ticks"] + counted["missed"] > 200, "a number for missed ticks, too"


def test_many_threads_watch_and_change():
    stop, errors = threading.Event(), []
    with palpa.live(head_scene(), hand="sim:circle", duration_s=60) as live:
        def work():
            array = np.zeros((6, 6, 6), np.int16)
            try:
                while not stop.is_set():
                    scene = live.scene
                    scene.modes["skin"].enabled = not scene.modes["skin"].enabled
                    scene.add_array(f"a{len(scene.volumes)}_{threading.get_ident()}"[:40], array.copy(), 0.01)
                    live.scene = head_scene()
                    live.latest(), live.statistics()
            except Exception as error:
                errors.append(error)

        threads = [threading.Thread(target=work) for _ in range(3)]
        for thread in threads:
            thread.start()
        time.sleep(1.5)
        stop.set()
        for thread in threads:
            thread.join()
    assert not errors


@pytest.mark.parametrize("end", ["", "raise SystemExit(3)", "del live", "1 / 0", "import os, signal; os.kill(os.getpid(), signal.SIGINT)"])
def test_the_interpreter_ends_while_it_is_felt(end, tmp_path):
    program = ("import palpa, time\nscene = palpa.Scene()\nscene.add('head', palpa.head_phantom())\n"
               "scene.add('skin', palpa.SurfaceAndFriction(field='head', levels=[dict(value=-300)]))\n"
               f"live = palpa.live(scene, hand='sim:stroke', out={str(tmp_path / 'trace')!r}, duration_s=100)\n"
               f"while live.latest()['tick'] < 50: time.sleep(0.01)\n{end}\n")
    child = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60)
    assert child.returncode >= 0 or "SIGINT" in end, child.stderr
    assert palpa.Trace(tmp_path / "trace").ticks["tick"][-1] >= 50


def test_a_child_process_cannot_touch_it():
    program = ("import palpa, os\nscene = palpa.Scene()\nscene.add('head', palpa.head_phantom())\n"
               "live = palpa.live(scene, hand='sim:stroke', duration_s=100)\nchild = os.fork()\n"
               "if child == 0:\n    try:\n        live.latest()\n    except RuntimeError as error:\n        assert 'forked' in str(error)\n"
               "        del live\n        os._exit(7)\n"
               "print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), live.is_running)\nlive.stop()\n")
    child = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60)
    assert child.stdout == "7 True\n" and child.returncode == 0, child.stderr


def test_a_device_that_is_not_there_is_told():
    with pytest.raises(palpa.LoadError) as told:
        palpa.live(head_scene(), device="inverse4")
    assert "\n" not in str(told.value)
    with pytest.raises(palpa.LoadError, match="hand"):
        palpa.live(head_scene())


def test_names_of_0_1_are_read_with_a_line_that_has_the_new_name():
    for old, new in (("Here", "ModeContext"), ("Out", "PrimitiveSink"), ("ModeTick", "ModeForce"), ("Pointer", "MouseHand")):
        with pytest.warns(palpa.PalpaWarning, match=f"^palpa.{old} is called {new} now$"):
            assert getattr(palpa, old) is getattr(palpa, new)
        assert old not in palpa.__all__
    field = head_scene().field("head")
    with pytest.warns(palpa.PalpaWarning, match="^Field.extents is called value_ranges now$"):
        assert field.extents == field.value_ranges
    with palpa.live(head_scene(), hand="sim:stroke", duration_s=0.2) as live:
        with pytest.warns(palpa.PalpaWarning, match="^Live.look is called latest now$"):
            assert live.look().keys() == live.latest().keys()
        with pytest.warns(palpa.PalpaWarning, match="^Live.account is called statistics now$"):
            assert live.account().keys() == live.statistics().keys()
        with pytest.raises(AttributeError, match="^Live: no attribute 'latests'; did you mean 'latest'\\?$"):
            live.latests()
    with pytest.raises(AttributeError, match="^Field: no attribute 'spacing'; did you mean 'spacing_m'\\?$"):
        field.spacing
    with pytest.raises(AttributeError, match="^module 'palpa' has no attribute 'Poynter'$"):
        palpa.Poynter


# ---- sliders ----


class Widget:
    """The members of ipywidgets' widgets that are used."""

    def __init__(self, children=(), **given):
        self.children, self.value, self.act = children, given.get("value"), None
        self.__dict__.update(given)

    def observe(self, act, names):
        assert names == "value"
        self.act = act

    def move(self, value):
        if self.act is None:  # of ipywidgets itself
            self.value = value
        else:
            self.act({"new": value})


@pytest.fixture
def widgets(monkeypatch):
    try:
        import ipywidgets
    except ImportError:
        ipywidgets = types.ModuleType("ipywidgets")
        ipywidgets.FloatSlider = ipywidgets.Label = ipywidgets.VBox = Widget
        ipywidgets.Layout = dict
        monkeypatch.setitem(sys.modules, "ipywidgets", ipywidgets)
    return ipywidgets


def move(slider, value):
    slider.move(value) if isinstance(slider, Widget) else setattr(slider, "value", value)


def test_sliders_change_the_scene_that_is_felt(widgets):
    scene = head_scene()
    scene.add("syrup", palpa.Viscosity(field="head", drag_ns_per_m=2), enabled=False)
    with palpa.live(scene, hand="sim:stroke", duration_s=5) as live:
        *sliders, says = live.sliders().children
        by_name = {slider.description: slider for slider in sliders}
        assert list(by_name) == ["coupling.stiffness_n_per_m", "skin.levels[0].strength_n", "skin.levels[0].friction_n",
                                 "syrup.drag_ns_per_m"]
        stiffness, strength = list(by_name.values())[:2]
        assert 0 < stiffness.min < stiffness.value == 400 < stiffness.max == 1200 and strength.min == 0
        move(strength, 1.5)
        move(stiffness, 300.0)
        assert live.scene.modes["skin"].mode.levels[0].strength_n == 1.5 and live.scene.stiffness_n_per_m == 300
        assert live.scene.modes["skin"].mode.levels[0].friction_n == 0.1 and says.value == ""
        (own, says) = live.sliders("skin.levels[0].value").children
        move(own, -200.0)
        assert live.scene.modes["skin"].mode.levels[0].value == -200
        with pytest.raises(KeyError, match="did you mean 'skin.levels.0..strength_n'"):
            live.sliders("skin.level[0].strength_n")
        wait_for(lambda: live.statistics()["scenes"] >= 1)


def test_sliders_say_what_they_need(monkeypatch):
    monkeypatch.setitem(sys.modules, "ipywidgets", None)
    with palpa.live(head_scene(), hand="sim:press", duration_s=0.1) as live:
        with pytest.raises(ImportError, match="sliders need ipywidgets; install python3-ipywidgets"):
            live.sliders()
