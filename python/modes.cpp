#include "modes.h"

#include <pybind11/stl.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "arrays.h"
#include "palpa/base/wording.h"
#include "parameters.h"
#include "python_mode.h"

namespace palpa::python {
namespace {

thread_local ModeFailure* watched_failure = nullptr;

/// Mode whose `place` is a C function.
struct CFunctionMode {
  static constexpr auto type = "c_function";
  static constexpr auto summary = "A mode that is a function of C.";

  /// \param in   proxy, probe and sample positions [m], 3 numbers each, time step [s], stiffness [N/m]; then of each scalar
  ///             field inside (1 or 0), value and gradient [unit/m]; of each vector field inside, 3 values and 9 of the
  ///             Jacobian
  /// \param out  rows of 9 for primitives: kind (0 point, 1 line, 2 plane, 3 directed force), position [m], direction [1],
  ///             strength [N], drag [N·s/m]; room for `most_primitives`
  /// Returns the number of rows.
  using Function = int (*)(const double* in, double* out);
  static constexpr std::size_t most_primitives = 16, most_fields = 8, numbers_of_one = 9;

  ReadFields scalars, vectors;
  Function function = nullptr;
  std::shared_ptr<const void> owner;  // keeps the function loaded
  /// Largest returned number of rows beyond the room, until reported; shared by all copies.
  std::shared_ptr<std::atomic<int>> excess = std::make_shared<std::atomic<int>>(0);

  void place(const ModeContext& here, PrimitiveSink out) const noexcept;
};
void visit_part(CFunctionMode& mode, ParameterVisitor& visitor) {
  mode.scalars.visit(ParameterKind::scalar_field, visitor);
  mode.vectors.visit(ParameterKind::vector_field, visitor);
}

void CFunctionMode::place(const ModeContext& here, PrimitiveSink out) const noexcept {
  std::array<double, 11 + 13 * most_fields> in;
  double* next = put(put(put(in.data(), here.proxy_m), here.probe_m), here.at_m);
  *next++ = here.time_step_s;
  *next++ = here.stiffness_n_per_m;
  for (const auto& [name, ref] : scalars.fields) {
    const ScalarSample sample = here.scalar(ref);
    *next++ = sample.inside ? 1.0 : 0.0;
    *next++ = sample.value;
    next = put(next, sample.gradient);
  }
  for (const auto& [name, ref] : vectors.fields) {
    const VectorSample sample = here.vector(ref);
    *next++ = sample.inside ? 1.0 : 0.0;
    next = put(next, sample.value);
    for (const Vec3& row : sample.jacobian.row) next = put(next, row);
  }
  std::array<double, numbers_of_one * most_primitives> rows{};
  const int filled = function(in.data(), rows.data());
  const std::size_t count = std::min(static_cast<std::size_t>(std::max(filled, 0)), most_primitives);
  if (filled > static_cast<int>(most_primitives)) excess->store(filled, std::memory_order_relaxed);
  for (std::size_t n = 0; n < count; ++n) {
    const double* const row = rows.data() + numbers_of_one * n;
    const Vec3 position_m{row[1], row[2], row[3]}, direction{row[4], row[5], row[6]};
    const double strength_n = here.newtons(Strength(row[7])), drag_ns_per_m = here.drag(row[8]);
    const auto slot = static_cast<std::uint16_t>(n);
    if (row[0] == 0.0) {
      out.point(slot, position_m, strength_n, drag_ns_per_m);
    } else if (row[0] == 1.0) {
      out.line(slot, position_m, direction, strength_n, drag_ns_per_m);
    } else if (row[0] == 2.0) {
      out.plane(slot, position_m, direction, strength_n, {}, drag_ns_per_m);
    } else if (row[0] == 3.0) {
      out.directed(slot, direction, strength_n);
    }
  }
}

}  // namespace

ModeFailure::Watch::Watch(ModeFailure& failure, std::atomic<bool>* stop) noexcept : before_(watched_failure) {
  failure.stop_ = stop;
  watched_failure = &failure;
}
ModeFailure::Watch::~Watch() { watched_failure = before_; }
ModeFailure* ModeFailure::watched() noexcept { return watched_failure; }
ModeFailure::~ModeFailure() = default;

void ModeFailure::keep(const py::error_already_set& error) noexcept {
  if (!error_) error_.emplace(error);
  if (stop_) *stop_ = true;
}

void ModeFailure::raise() {
  if (!error_) return;
  const py::error_already_set error = *std::exchange(error_, std::nullopt);
  throw error;
}

std::string what_is_not_for_real_time(const Scene& scene) {
  for (const SceneMode& mode : scene.modes()) {
    if (mode.enabled && is_in_python(mode.mode)) {
      return "mode " + detail::in_quotes(mode.name) +
             " is written in Python, which keeps no time: beside one busy thread a tick takes 5 ms; feel it with palpa.run, or "
             "give palpa.CFunction a function of C";
    }
  }
  return {};
}

std::vector<std::string> warnings_of_modes(const Scene& scene) {
  std::vector<std::string> sentences;
  for (const SceneMode& mode : scene.modes()) {
    const auto* const function = mode.mode.as<CFunctionMode>();
    const int returned = function ? function->excess->exchange(0, std::memory_order_relaxed) : 0;
    if (returned == 0) continue;
    sentences.push_back("mode " + detail::in_quotes(mode.name) + ": its function of C returned " + std::to_string(returned) +
                        " rows; there is room for " + std::to_string(CFunctionMode::most_primitives) +
                        ", and those beyond are not felt");
  }
  return sentences;
}

void warn_of_modes(const Scene& scene) {
  for (const std::string& sentence : warnings_of_modes(scene)) {
    const py::object category = py::module_::import("palpa").attr("PalpaWarning");
    if (PyErr_WarnEx(category.ptr(), sentence.c_str(), 1) != 0) throw py::error_already_set();
  }
}

bool may_tell(const Scene& scene) {
  return std::ranges::any_of(scene.modes(), [](const SceneMode& mode) { return mode.mode.as<CFunctionMode>() != nullptr; });
}

void bind_modes(py::module_& module) {
  bind_python_modes(module);
  module.def("told_by_modes", &warnings_of_modes);
  module.def("c_function_mode", [](std::uintptr_t address, const std::vector<std::pair<std::string, std::string>>& scalars,
                                   const std::vector<std::pair<std::string, std::string>>& vectors, const py::object& owner) {
    if (address == 0) throw py::value_error("the function's address is 0; give that of a function of C");
    if (scalars.size() + vectors.size() > CFunctionMode::most_fields) {
      throw py::value_error("a function of C reads at most " + std::to_string(CFunctionMode::most_fields) + " fields");
    }
    CFunctionMode mode{.scalars = ReadFields(scalars),
                       .vectors = ReadFields(vectors),
                       .function = reinterpret_cast<CFunctionMode::Function>(address),
                       .owner = kept(owner, owner.ptr())};
    return PartPtr(std::make_shared<ModePart>(Mode(std::move(mode))));
  });
}

}  // namespace palpa::python
