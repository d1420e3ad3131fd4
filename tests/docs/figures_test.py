"""The numbers in the figures of tools/figures obey the statements that they illustrate, and each figure is drawn."""

import pathlib
import sys
import xml.etree.ElementTree

import pytest

np = pytest.importorskip("numpy")
pytest.importorskip("matplotlib")
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "tools" / "figures"))
import common  # noqa: E402
import design_figures as design  # noqa: E402
import paper_figures as paper  # noqa: E402
import path_figures as path  # noqa: E402
import theory_figures as theory  # noqa: E402


@pytest.mark.parametrize("row", design.tick_rows + design.voxel_rows, ids=lambda row: row[1])
def test_design_each_step_is_a_function_of_its_source(row):
    _, function, _, source = row
    file = next(f for f in (common.root / "palpa" / source, common.root / source) if f.exists())
    assert function.split("::")[-1] in file.read_text() or function in ("protocol", "palpa-read")


@pytest.mark.parametrize("kind", ["point", "line", "plane", "directed"])
def test_fig1_exerted_forces_are_the_strength_and_felt_ones_the_spring_up_to_it(kind):
    s, k = 1.3, 400.0
    places_mm, exerted_n, felt_n = paper.force_law(kind, s, k)
    side, pull_n = -np.sign(places_mm), -1e-3 * k * places_mm
    least = {"plane": 0.0, "directed": 1.0}.get(kind, -1.0)
    np.testing.assert_allclose(exerted_n, s * np.maximum(side, least), atol=1e-12)
    np.testing.assert_allclose(felt_n, np.clip(pull_n, least * s, s), atol=1e-9 * k)


def test_fig2_forces_cancel_and_each_is_one_that_its_primitive_can_exert():
    (wall, point), _, proxy_m, (of_plane, of_point, of_spring) = paper.plane_and_point()
    assert common.norm(of_plane + of_point + of_spring) < 1e-6
    assert common.norm(of_plane) == pytest.approx(of_plane @ wall[2], abs=1e-12) and common.norm(of_plane) <= wall[3] + 1e-12
    assert common.norm(of_point) == pytest.approx(point[3], abs=1e-9) and of_point @ (np.array(point[1]) - proxy_m) > 0
    assert proxy_m[1] == pytest.approx(0.0, abs=1e-9)


def test_fig3_the_proxy_leads_by_at_most_strength_over_stiffness():
    probes_mm = np.array([6, 1, 0, -1, -3.9, -4, -4.1, -20, -2, 5])
    proxies_mm = paper.proxies_over_plane_mm(probes_mm, 0.8, 200.0)  # s/k = 4 mm
    np.testing.assert_allclose(proxies_mm, probes_mm + np.clip(-probes_mm, 0, 4), atol=1e-6)


def test_fig4_friction_is_a_play_of_strength_over_stiffness():
    k, line_n = 100.0, 0.4
    probes_mm, proxies_mm, friction_n, normal_n = common.friction_loop(0.006, 1.0, line_n, k, 0.02, 150)
    play_mm, plays_mm = 0.0, []  # the play operator: the proxy follows a probe more than s/k away
    for probe_mm in probes_mm:
        play_mm = np.clip(play_mm, probe_mm - 1e3 * line_n / k, probe_mm + 1e3 * line_n / k)
        plays_mm.append(play_mm)
    np.testing.assert_allclose(proxies_mm, plays_mm, atol=1e-5)
    np.testing.assert_allclose(normal_n, k * 0.006, atol=1e-6)
    np.testing.assert_allclose(friction_n, 1e-3 * k * (np.array(plays_mm) - probes_mm), atol=1e-6)


def test_fig5_the_law_of_2003_is_off_by_the_cosine_and_ours_is_not():
    way_m = common.norm(paper.probe_5_m)
    for angle in range(5, 180, 5):
        off_m = common.norm(common.law_of_planes("ikits-2003", angle, paper.probe_5_m) - paper.probe_5_m)
        assert off_m == pytest.approx(abs(np.cos(np.radians(angle))) * way_m, abs=1e-12)
        assert common.norm(common.law_of_planes("exact", angle, paper.probe_5_m) - paper.probe_5_m) < 1e-9


def test_laws_shares_are_those_of_the_values():
    values = np.sort(np.append([0.0, 0.0, 1e-7, 1e-7, 2.0], np.random.default_rng(3).lognormal(-8, 4, 500)))
    places, shares = common.shares_up_to(values, 1e-6)
    assert places[0] == 1e-6 and places[-1] == values[-1] and (np.diff(places) > 0).all()
    np.testing.assert_allclose(shares, [100.0 * np.mean(values <= place) for place in places], atol=1e-9)
    assert len(common.shares_up_to(np.array([]), 1e-6)[0]) == 0


def test_laws_ours_is_proven_and_earlier_ones_are_off_where_constraints_are_oblique():
    oblique, orthogonal = paper.compared("many_phantom.toml"), paper.compared("head_phantom.toml")
    for comparison in (oblique, orthogonal):
        assert comparison.posed_m["exact"].max() <= 1e-9 and comparison.alone_n["exact"].max() <= 1e-4
    for law in ("ikits-2003", "ikits-2003-sequential", "no-proxy"):
        assert np.median(oblique.posed_m[law]) > 1e-4
    for law in ("ikits-2003", "ikits-2003-sequential"):
        assert orthogonal.posed_m[law].max() <= 1e-12
    assert np.median(orthogonal.posed_m["paper-2005"]) > 1e-9


@pytest.mark.parametrize("speed", [0.1, 1.0])
def test_a_plane_at_the_proxy_drifts_by_pi_speed_times_tick_and_ours_does_not(speed):
    assert path.off_sphere_m(True, False, speed)[-1] == pytest.approx(np.pi * speed * 1e-3, rel=0.1)
    assert np.abs(path.off_sphere_m(False, True, speed)).max() < 1e-9


def test_in_a_groove_the_path_rests_and_one_step_a_tick_does_not():
    def jump_n(found):  # the largest change of the force with a still hand, after a few settling ticks
        forces_n, _, still, slides, _, _ = found
        return np.linalg.norm(np.diff(forces_n[still + 9:slides], axis=0), axis=1).max()

    ours = path.press_into_groove(False)
    assert jump_n(ours) < 1e-3 and jump_n(path.press_into_groove(True)) > 0.1
    assert sum(common.norm(force_n) > 1e-3 for _, _, force_n in ours[-1]) >= 2, "several planes carry it together"


@pytest.mark.parametrize("speed", [0.1, 1.0, 10.0])
def test_a_thin_wall_holds_the_path_at_any_speed(speed):
    for i in range(10):
        probe_m, proxy_m = path.stroke_through_wall(False, speed, speed * 1e-4 * i)
        assert probe_m[-1] > path.wall_m and proxy_m[-1] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("modes", [path.convergence_in_scalars, path.convergence_in_vectors])
def test_paths_converge(modes):
    for name, apart_m in modes().items():
        assert apart_m[-1] < 3e-6 and apart_m[-1] < apart_m[0], name


def test_bounds_lie_above_errors():
    for seed in range(1, 101):
        errors_m, bounds_m, _ = theory.sweeps_towards_balance(seed, 30).T
        assert (bounds_m >= errors_m - 1e-9).all(), seed


@pytest.mark.parametrize("angle", [5.0, 30.0, 70.0])
def test_sweeps_leave_the_squared_cosine_of_the_error(angle):
    distances_m = theory.sweeps_into_edge(angle, 100000)
    assert distances_m[-1] < 1e-9
    ratios = distances_m[1:-1] / distances_m[:-2]
    np.testing.assert_allclose(ratios, np.cos(np.radians(angle))**2, atol=1e-4)
    planes, probe_m, k = theory.edge_of(angle)  # the fast sweep of two planes equals the general sweep
    forces_n = np.zeros((2, 3))
    for distance_m in distances_m[:20]:
        assert common.norm(theory.sweep(planes, forces_n, probe_m, k)) == pytest.approx(distance_m, abs=1e-15)


def test_the_exact_law_hardly_depends_on_the_angle():
    _, sweeps, _, ours = theory.sweeps_over_angle()
    assert np.isfinite(ours).all(), "it reaches the edge at every angle"
    assert sweeps[0] > 100 * ours[0] and ours.max() <= 10 * ours.min()


def test_steps_through_the_proxy_leak_no_more_than_proven_and_others_do():
    leak_j, bound_j = theory.random_steps(False, 1000)
    assert (leak_j <= bound_j + 1e-11).all()
    leak_j, bound_j = theory.random_steps(True, 1000)
    assert (leak_j > bound_j).sum() > 50


names = ["design-tick", "design-voxel", "fig1-primitives", "fig2-balance", "fig3-plane", "fig4-friction",
         "fig5-constraints", "laws", "path-drift", "path-groove", "path-order", "path-wall", "theory-bound", "theory-energy", "theory-passivity", "theory-sum",
         "theory-sweeps"]


def test_every_figure_of_the_documentation_is_there():
    assert sorted(common.figures) == names  # and claims, which tests/docs/reproduction_test.sh draws


def test_a_figure_is_the_same_twice(tmp_path):
    first, second = (common.write(tmp_path / folder, ["fig4-friction"]) for folder in "ab")
    assert [file.read_bytes() for file in first] == [file.read_bytes() for file in second]


@pytest.mark.parametrize("name", names)
def test_figures_are_well_formed_and_label_their_axes_with_units(name, tmp_path):
    svg, png = (file.read_bytes() for file in common.write(tmp_path, [name]))
    assert png.startswith(b"\x89PNG\r\n")
    drawn = xml.etree.ElementTree.fromstring(svg)
    texts = ["".join(each.itertext()) for each in drawn.iter("{http://www.w3.org/2000/svg}text")]
    assert any(" / " in text for text in texts) or name in ("design-tick", "design-voxel", "fig2-balance", "fig3-plane", "theory-sum")
    description = drawn.find(".//{http://purl.org/dc/elements/1.1/}description")
    assert len(description.text) > 40, "the caption"
