// The module figure_laws, for figures beyond the Python package: single balances by any law, a proven bound of any forces,
// sessions on another path, and a released device.
#include <palpa/palpa.h>
#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "palpa/baseline/law.h"
#include "palpa/data/field.h"
#include "palpa/solver/solver.h"
#include "palpa/study/released_device.h"

namespace py = pybind11;

namespace palpa::figures {
namespace {

using Three = std::array<double, 3>;
Vec3 vec3(const Three& v) { return {v[0], v[1], v[2]}; }
py::array_t<double> array_of(const Vec3& v) {
  py::array_t<double> made(3);
  std::copy_n(&v.x, 3, made.mutable_data());
  return made;
}
py::array_t<double> array_of(std::span<const Vec3> rows) {
  py::array_t<double> made({static_cast<py::ssize_t>(rows.size()), py::ssize_t{3}});
  double* to = made.mutable_data();
  for (const Vec3& v : rows) to = std::copy_n(&v.x, 3, to);
  return made;
}

/// (kind, position [m], direction [1], strength [N], drag [N s/m])
using PrimitiveRow = std::tuple<std::string, Three, Three, double, double>;

std::vector<Primitive> primitives_of(const std::vector<PrimitiveRow>& rows) {
  std::vector<Primitive> primitives;
  for (const auto& [kind, position, direction, strength_n, drag] : rows) {
    Primitive primitive;
    primitive.position_m = vec3(position);
    primitive.direction = vec3(direction);
    primitive.strength_n = strength_n;
    primitive.drag_ns_per_m = drag;
    primitive.id.slot = static_cast<std::uint16_t>(primitives.size());
    for (const PrimitiveKind each : {PrimitiveKind::point, PrimitiveKind::line, PrimitiveKind::plane, PrimitiveKind::directed})
      if (kind == name_of(each)) primitive.kind = each;
    primitives.push_back(primitive);
  }
  return primitives;
}

std::unique_ptr<Law> law_of(const std::string& name) {
  std::unique_ptr<Law> law = baseline::law(name);
  if (!law) throw py::value_error("there is no law " + name);
  return law;
}

/// (balance [m], forces [N], proven bound [m], iterations)
py::tuple solve(Law& law, const std::vector<PrimitiveRow>& rows, const Three& start, const Three& probe,
                double stiffness_n_per_m, double time_step_s) {
  PrimitiveSet set;
  set.clear(vec3(start));
  for (const Primitive& primitive : primitives_of(rows)) set.add(primitive);
  if (set.dropped() > 0) throw py::value_error("a primitive was refused");
  const Balance balance = law.solve(set, vec3(start), vec3(probe), stiffness_n_per_m, time_step_s);
  return py::make_tuple(array_of(balance.position_m), array_of(law.forces_n()), balance.error_bound_m, balance.iterations);
}

double bound_m(const std::vector<PrimitiveRow>& rows, const std::vector<Three>& forces, const Three& x, const Three& probe,
               double stiffness_n_per_m, double time_step_s) {
  std::vector<Vec3> forces_n;
  for (const Three& force : forces) forces_n.push_back(vec3(force));
  return error_bound_m(primitives_of(rows), forces_n, vec3(x), vec3(probe), stiffness_n_per_m, time_step_s);
}

/// A session in `steps` sub-steps a tick, or in one step a tick for any law.
class PathSession {
 public:
  PathSession(const Scene& scene, bool one_step, int steps)
      : session_(one_step ? Session::in_one_step(scene) : Session(scene)) {
    if (steps > 0) session_.refine_path(steps);
  }
  /// (proxies [m], forces [N], yielding levels (tick, depth [m])), a row for each tick
  py::tuple ticks(const py::array_t<double, py::array::c_style | py::array::forcecast>& probes_m, double dt_s) {
    const auto probes = probes_m.unchecked<2>();
    std::vector<Vec3> proxies, forces;
    std::vector<std::pair<py::ssize_t, double>> broken;
    for (py::ssize_t n = 0; n < probes.shape(0); ++n) {
      const Tick tick = session_.tick({.position_m = {probes(n, 0), probes(n, 1), probes(n, 2)}}, dt_s);
      proxies.push_back(tick.proxy_m);
      forces.push_back(tick.force_n);
      for (const SessionEvent& event : session_.events())
        if (event.kind == SessionEventKind::break_through) broken.emplace_back(n, event.depth_m);
    }
    return py::make_tuple(array_of(proxies), array_of(forces), broken);
  }
  /// (direction, strength [N], force [N]) of each primitive in the last sub-step
  py::list last_primitives() const {
    py::list all;
    for (const PlacedPrimitive& placed : session_.primitives().subspan(session_.sub_steps().back().first_primitive))
      all.append(py::make_tuple(array_of(placed.primitive.direction), placed.primitive.strength_n, array_of(placed.force_n)));
    return all;
  }
  void copy_state_from(const PathSession& other) { session_.copy_state_from(other.session_); }

 private:
  Session session_;
};

/// A plate across x: value = depth [m] in it.
class Plate final : public Field {
 public:
  explicit Plate(double thickness_m) : half_m_(0.5 * thickness_m) {}
  int components() const noexcept override { return 1; }
  ScalarSample scalar(const Vec3& x) const noexcept override {
    if (!(depth_m(x) >= 0.0)) return {};
    return {half_m_ - std::abs(x.x - half_m_), {x.x < half_m_ ? 1.0 : -1.0, 0, 0}, true};
  }
  double spacing_m() const noexcept override { return 1e-3; }
  Box bounds_m() const noexcept override { return {{-box_m, -box_m, -box_m}, {box_m, box_m, box_m}}; }
  double depth_m(const Vec3& x) const noexcept override {
    return is_finite(x) ? box_m - std::max({std::abs(x.x), std::abs(x.y), std::abs(x.z)}) : -box_m;
  }
  std::vector<ValueRange> value_ranges() const override { return {{-box_m - half_m_, half_m_}}; }

 private:
  static constexpr double box_m = 0.2;
  double half_m_;
};

Volume plate(double thickness_m) {
  Volume volume;
  volume.fields = {{"depth", "m", std::make_shared<Plate>(thickness_m)}};
  volume.format = "formula";
  return volume;
}

/// A device as in docs/felt.md: without friction, which would hide the loop's effect, and with some damping.
DevicePlant bare_device(const std::string& name) {
  DevicePlant plant = device_plant(name);
  plant.coulomb_friction_n = 0.0;
  plant.damping_ns_per_m = std::max(0.1, plant.damping_ns_per_m);
  return plant;
}

PYBIND11_MODULE(figure_laws, module) {
  py::module_::import("palpa");  // Scene and Volume are classes of it
  py::class_<Law>(module, "Law")
      .def(py::init(&law_of))
      .def("reset", &Law::reset)
      .def("solve", &solve, py::arg("primitives"), py::arg("start_m"), py::arg("probe_m"), py::arg("stiffness_n_per_m"),
           py::arg("time_step_s") = 1e-3);
  module.def("error_bound_m", &bound_m, py::arg("primitives"), py::arg("forces_n"), py::arg("x_m"), py::arg("probe_m"),
             py::arg("stiffness_n_per_m"), py::arg("time_step_s") = 1e-3);
  py::class_<PathSession>(module, "Session")
      .def(py::init<const Scene&, bool, int>(), py::arg("scene"), py::arg("one_step") = false, py::arg("steps") = 0)
      .def("ticks", &PathSession::ticks, py::arg("probes_m"), py::arg("dt_s") = 1e-3)
      .def("last_primitives", &PathSession::last_primitives)
      .def("copy_state_from", &PathSession::copy_state_from);
  module.def("plate", &plate, py::arg("thickness_m"));
  module.def("device_damping_ns_per_m", [](const std::string& name) { return bare_device(name).damping_ns_per_m; });
  module.def("comes_to_rest", [](const std::string& name, double damping_ns_per_m, double stiffness_n_per_m) {
    return comes_to_rest({.plant = bare_device(name), .damping_ns_per_m = damping_ns_per_m}, stiffness_n_per_m);
  });
  // Identical on every machine: the standard distributions differ between libraries.
  module.def("uniform", [](unsigned seed, py::ssize_t count) {
    std::mt19937_64 bits(seed);
    py::array_t<double> numbers(count);
    std::generate_n(numbers.mutable_data(), count, [&] { return static_cast<double>(bits() >> 11) * 0x1p-53; });
    return numbers;
  });
}

}  // namespace
}  // namespace palpa::figures
