#include "study.h"

#include <pybind11/numpy.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <stdexcept>

#include "interruptible.h"
#include "palpa/base/wording.h"
#include "palpa/baseline/law.h"
#include "palpa/device/hand.h"
#include "palpa/study/compare_laws.h"
#include "palpa/study/run.h"
#include "palpa/trace/export_trace.h"
#include "parameters.h"
#include "run_options.h"

namespace palpa::python {
namespace {

namespace fs = std::filesystem;
bool flag_of(py::handle value, const std::string& name) {
  if (PyBool_Check(value.ptr())) return value.cast<bool>();
  throw py::type_error(detail::in_quotes(name) + " takes True or False, not " +
                       value.get_type().attr("__name__").cast<std::string>());
}

Place place_of(const std::string& word) {
  std::vector<std::string> words;
  for (const Place place : {Place::as_recorded, Place::centred, Place::fitted}) {
    if (word == name_of(place)) return place;
    words.emplace_back(name_of(place));
  }
  throw py::value_error("no place " + detail::in_quotes(word) + "; " + detail::suggestion(word, words));
}

std::shared_ptr<const Target> positions_of(py::handle given, const py::object& dt_s) {
  const Numbers rows = rows_of(given, "positions_m", 3);
  std::vector<Vec3> positions_m;
  positions_m.reserve(static_cast<std::size_t>(rows.shape(0)));
  for (py::ssize_t n = 0; n < rows.shape(0); ++n) positions_m.push_back({rows.at(n, 0), rows.at(n, 1), rows.at(n, 2)});
  return sampled_target(positions_m, time_step_of(dt_s));
}

py::tuple compare(const Scene& given, const py::object& positions_m, const py::object& time_step,
                  const std::vector<std::string>& laws) {
  const double dt_s = time_step_of(time_step);
  const Numbers positions = rows_of(positions_m, "positions_m", 3);
  std::vector<Probe> probes;
  for (py::ssize_t n = 0; n < positions.shape(0); ++n)
    probes.push_back({.position_m = {positions.at(n, 0), positions.at(n, 1), positions.at(n, 2)}});
  const Scene scene = given;
  const LawComparison comparison =
      interruptible([&](const std::atomic<bool>&, const std::stop_token&) { return compare_laws(scene, probes, dt_s, laws); });
  py::dict errors;
  for (const LawErrors& law : comparison.laws) {
    errors[py::str(law.law)] =
        py::make_tuple(py::array_t<double>(py::ssize_t(law.posed_errors_m.size()), law.posed_errors_m.data()),
                       py::array_t<double>(py::ssize_t(law.alone_errors_n.size()), law.alone_errors_n.data()));
  }
  return py::make_tuple(comparison.ticks, comparison.balances, comparison.left_out, errors, to_markdown(comparison));
}

}  // namespace

LoadedScene loaded_of(const Scene& scene) { return {scene, to_toml(scene), scene.check()}; }

RunOptions run_options(const py::dict& given) {
  RunOptions options;
  for (const auto& [key, value] : given) {
    const auto name = key.cast<std::string>();
    if (value.is_none()) continue;
    if (name == "scene")
      options.scene = value.cast<fs::path>();
    else if (name == "hand")
      options.hand = value.cast<std::string>();
    else if (name == "device")
      options.device = value.cast<std::string>();
    else if (name == "duration_s")
      options.duration_s = number_of(value, name);
    else if (name == "rate_hz")
      options.rate_hz = number_of(value, name);
    else if (name == "out")
      options.out = value.cast<fs::path>();
    else if (name == "place")
      options.place = place_of(value.cast<std::string>());
    else if (name == "positions_m")
      options.target = positions_of(value, given["dt_s"]);
    else if (name == "primitives")
      options.primitives = flag_of(value, name);
    else if (name == "data")
      options.scene_options.data_folders = value.cast<std::vector<fs::path>>();
    else if (name == "plugins")
      options.plugins = value.cast<std::vector<fs::path>>();
    else if (name == "hold") {
      const auto word = value.cast<std::string>();
      if (word == "rigid")
        options.hold = Hold::rigid;
      else if (word == "relaxed")
        options.hold = Hold::relaxed;
      else if (word == "firm")
        options.hold = Hold::firm;
      else
        throw py::value_error("no hold '" + word + "'; there are: rigid, relaxed, firm");
    }
  }
  return options;
}

void bind_study(py::module_& module) {
  module.def("run", [](const py::object& scene, const py::dict& given) {
    RunOptions options = run_options(given);
    const bool is_loaded = py::isinstance<Scene>(scene);
    LoadedScene loaded;
    if (is_loaded) loaded.scene = scene.cast<const Scene&>();
    const RunResult result = interruptible([&](const std::atomic<bool>& stop, std::stop_token token) {
      options.read.stop = std::move(token);
      if (!is_loaded) return run(options, &stop);
      return run(prepare(loaded_of(loaded.scene), options), options, &stop);
    });
    // Notes report unrequested changes and omitted parts: the caller has to read them.
    std::vector<std::string> sentences = result.warnings;
    sentences.insert(sentences.end(), result.summary.notes.begin(), result.summary.notes.end());
    for (std::string& sentence : warnings_of_modes(loaded.scene)) sentences.push_back(std::move(sentence));
    return py::make_tuple(to_json(result.summary), sentences);
  });
  module.def("place_by_fit", [](const fs::path& hand, bool is_fitted) {
    RunOptions options;
    options.hand = hand.string();
    return name_of(place_by_fit(options, is_fitted));
  });
  module.def("replay", [](const fs::path& trace, const std::vector<fs::path>& data, const std::vector<fs::path>& plugins) {
    const ReplayResult result = interruptible([&](const std::atomic<bool>& stop, std::stop_token token) {
      return replay(trace, data, {.stop = std::move(token)}, &stop, plugins);
    });
    return py::make_tuple(result.difference.same, result.difference.where, result.difference.ticks, result.cut);
  });
  module.def("export_trace", [](const fs::path& trace, const fs::path& file, bool replace) {
    const py::gil_scoped_release release;
    export_trace(trace, file, replace ? detail::Existing::replaced : detail::Existing::refused);
  });
  module.def("compare_traces", [](const fs::path& recorded, const fs::path& again) {
    const TraceDifference difference =
        interruptible([&](const std::atomic<bool>&, const std::stop_token&) { return compare_traces(recorded, again); });
    return py::make_tuple(difference.same, difference.where, difference.ticks);
  });
  module.def(
      "laws", [] { return std::vector<std::string>(baseline::law_names.begin(), baseline::law_names.end()); },
      "The names of all laws, the exact one first.");
  module.def("compare_laws", &compare);
}

}  // namespace palpa::python
