"""Scenes of several hands: the scene of each, by name and number."""

import pickle

import numpy as np
import pytest

import palpa

TWO = """palpa = 1
[[hand]]
name = "thumb"
[hand.tool]
shape = "ball"
radius_m = 0.008
points = 12
[[hand]]
name = "finger"
at_m = [0.03, 0, 0]
[workspace]
fit = "head"
[volume.head]
analytic = "head_phantom"
[[mode]]
name = "skin"
type = "surface_and_friction"
field = "head"
[[mode.level]]
value = -300
strength_n = 0.8
"""
BALL = dict(shape="ball", radius_m=0.008, points=12)


def two_hands():
    scene = palpa.Scene(stiffness_n_per_m=500)
    scene.add("floor", palpa.plane_field())
    scene.workspace.scale = 2
    scene.workspace.center = (0, 0, 0)
    scene.add("floor", palpa.SurfaceAndFriction(field="floor", levels=[dict(value=0, strength_n=100)]))
    scene.add_hand("thumb", at_m=(-0.02, 0, 0.001), tool=palpa.ToolOptions(**BALL))
    scene.add_hand("finger", at_m=(0.02, 0.01, 0))
    return scene


def test_a_scene_has_its_hands_by_name():
    assert dict(palpa.Scene().hands) == {}
    scene = two_hands()
    assert list(scene.hands) == ["thumb", "finger"]
    assert scene.hands["thumb"].tool == palpa.ToolOptions(**BALL) == scene.tool
    np.testing.assert_array_equal(scene.hands["finger"].at_m, (0.02, 0.01, 0))
    assert scene.hands["finger"].tool == palpa.ToolOptions()
    with pytest.raises(KeyError, match="did you mean 'thumb'"):
        scene.hands["thum"]
    assert "[[hand]]" in scene.to_toml() and scene == scene.copy()
    again = pickle.loads(pickle.dumps(scene))
    assert again.to_toml() == scene.to_toml()


def test_the_scene_of_a_hand_begins_where_the_hand_is():
    scene = two_hands()
    whole = scene.hand_to_world()
    assert (scene.of_hand(0).hand_to_world() == whole).all(), "that of the first"
    for number, (name, hand) in enumerate(scene.hands.items()):
        alone = scene.of_hand(name)
        assert alone == scene.of_hand(number) == scene.of_hand(np.int64(number))
        assert list(alone.hands) == [name] and alone.tool == hand.tool
        origin = whole @ (*(hand.at_m - scene.hands["thumb"].at_m), 1)
        np.testing.assert_allclose(alone.hand_to_world()[:, 3], origin, atol=1e-15)


def test_each_hand_is_felt_by_itself():
    scene = two_hands()
    path = np.column_stack([np.zeros(100), np.zeros(100), np.linspace(0.02, -0.01, 100)])
    felt = {name: palpa.Session(scene.of_hand(name)).ticks(path, 1e-3) for name in scene.hands}
    assert palpa.Session(scene).ticks(path, 1e-3).tobytes() == felt["thumb"].tobytes(), "a session is the first hand's"
    lowest_foot_m = 0.008
    first = {name: rows["probe_m"][np.linalg.norm(rows["force_n"], axis=1) > 1e-3][0, 2] for name, rows in felt.items()}
    # In metres of the hand: the thumb's frame is 1 mm higher, and its ball is felt before its middle arrives.
    assert -0.001 - 5e-4 < first["thumb"] < -0.001 + lowest_foot_m
    assert -5e-4 < first["finger"] <= 0


def test_scene_files_are_opened_by_hand(tmp_path):
    file = tmp_path / "two.toml"
    file.write_text(TWO)
    both = palpa.load_scene(file)
    assert list(both.hands) == ["thumb", "finger"]
    finger = palpa.load_scene(file, hand="finger")
    assert finger == palpa.load_scene(file, hand=1) == palpa.load_scene(file, sets={"only_hand": "finger"}) == both.of_hand("finger")
    with pytest.raises(palpa.LoadError, match=r"the scene has 2 hands \(thumb, finger\); feel one of them: .*hand='thumb'"):
        palpa.run(file, "sim:press", duration_s=0.1)
    assert palpa.run(finger, "sim:press", duration_s=0.5).replay().same


def test_unknown_hands_are_refused():
    scene = two_hands()
    with pytest.raises(palpa.SceneError, match="no hand 'fingr'; did you mean 'finger'"):
        scene.of_hand("fingr")
    for wrong in (2, -1):
        with pytest.raises(IndexError, match=f"'hand' is {wrong}; the scene has 2 hands, counted from 0"):
            scene.of_hand(wrong)
    for wrong in (None, 0.5, True, []):
        with pytest.raises(TypeError, match="'hand' takes the name or the number of a hand"):
            scene.of_hand(wrong)
    assert palpa.Scene().of_hand(0) == palpa.Scene()
    with pytest.raises(palpa.SceneError, match="thumb"):
        scene.add_hand("thumb")
    for wrong in (dict(tool=BALL), dict(at_m="here")):
        with pytest.raises(TypeError, match="'tool' takes a palpa.ToolOptions, not dict|'at_m' takes"):
            scene.add_hand("third", **wrong)
    with pytest.raises(palpa.SceneError):
        scene.add_hand("third", at_m=(2, 0, 0))
    assert list(scene.hands) == ["thumb", "finger"], "nothing changed"
