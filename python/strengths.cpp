#include "strengths.h"

#include <string>
#include <utility>
#include <vector>

#include "palpa/base/wording.h"
#include "parameters.h"

namespace palpa::python {
namespace {

TransferFunction transfer_function(const py::iterable& points, double outside) {
  std::vector<TransferFunction::Point> all;
  for (const py::handle point : points) {
    const auto numbers = maybe_numbers(point);
    if (!numbers || numbers->size() != 2) throw py::type_error("'points' takes pairs (value, result)");
    all.push_back({(*numbers)[0], (*numbers)[1]});
  }
  return TransferFunction(std::move(all), outside);
}

py::tuple points_of(const TransferFunction& curve) {
  py::list points;
  for (const TransferFunction::Point& point : curve.points()) points.append(py::make_tuple(point.value, point.result));
  return py::tuple(points);
}

void check_range(const Strength&) {}  // checked by the mode's parameter
void check_range(const Mask& mask) {
  const auto check = [](double factor) {
    if (factor < 0.0 || factor > 1.0)
      throw py::value_error("Mask: a factor is " + detail::toml_number(factor) + "; it lies between 0 and 1");
  };
  for (const TransferFunction::Point& point : mask.curve.points()) check(point.result);
  check(mask.curve.outside());
}

/// Class of functions of a field: of, points, outside.
template <class T>
void bind_function(py::module_& module, const char* name, const char* doc) {
  py::class_<T>(module, name, doc)
      .def(py::init([](const std::string& of, const py::iterable& points, double outside) {
             T made;
             made.of = FieldRef{of};
             made.curve = transfer_function(points, outside);
             check_range(made);
             return made;
           }),
           py::kw_only(), py::arg("of"), py::arg("points"), py::arg("outside") = 0.0)
      .def_property_readonly(
          "of", [](const T& f) { return f.of.name; }, "scalar field whose value is looked up")
      .def_property_readonly(
          "points", [](const T& f) { return points_of(f.curve); }, "pairs (value, result), piecewise linear")
      .def_property_readonly(
          "outside", [](const T& f) { return f.curve.outside(); }, "result beyond the points")
      .def(
          "__eq__", [](const T& a, const T& b) { return a == b; }, py::is_operator())
      .def("__hash__", [](const T& f) { return py::hash(py::make_tuple(f.of.name, points_of(f.curve), f.curve.outside())); })
      .def(py::pickle([](const T& f) { return py::make_tuple(f.of.name, points_of(f.curve), f.curve.outside()); },
                      [](const py::tuple& state) {
                        T made;
                        made.of = FieldRef{state[0].cast<std::string>()};
                        made.curve = transfer_function(state[1], state[2].cast<double>());
                        return made;
                      }))
      .def("__repr__", [name](const T& f) {
        return py::str("{}(of={!r}, points={!r}, outside={!r})").format(name, f.of.name, points_of(f.curve), f.curve.outside());
      });
}

}  // namespace

void bind_strengths(py::module_& module) {
  bind_function<Strength>(
      module, "Strength",
      "A strength in newtons as a function of a field's value: `of` names a scalar field, `points` are pairs\n"
      "(value, newtons) whose values do not fall, two equal ones make a step; `outside` holds beyond them.");
  bind_function<Mask>(module, "Mask",
                      "A factor between 0 and 1 on all strengths and drags of a mode, as a function of a field's value.");
}

}  // namespace palpa::python
