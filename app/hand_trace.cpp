#include "app/hand_trace.h"

#include <cmath>

#include "palpa/base/load_error.h"
#include "palpa/trace/csv.h"

namespace palpa::app {
namespace {

constexpr std::size_t written_at_bytes = std::size_t{1} << 16;  // more: memory; fewer: many small writes

void put(std::string& row, const Vec3& v) {
  for (const double x : {v.x, v.y, v.z}) {
    row += ',';
    detail::put_number(row, x);
  }
}

}  // namespace

RunOptions HandTrace::options_of(RunOptions options, int number) {
  options.out /= "hand-" + std::to_string(number);
  return options;
}

detail::Recording HandTrace::begun(const RunOptions& options, const LoadedScene& loaded, const DeviceLimits& limits) {
  PreparedRun prepared{.loaded = loaded};
  TraceHeader header = detail::header_of(options, prepared, limits);
  detail::hold_to(limits, prepared, header);
  return {options, header, prepared.loaded};
}

HandTrace::HandTrace(const RunOptions& options, const LoadedScene& loaded, const DeviceLimits& limits, int number)
    : options_(options_of(options, number)),
      recording_(begun(options_, loaded, limits)),
      felt_(options_.out / "hand.csv", detail::Existing::refused),
      rows_(
          "tick,t_s,sample,command_x_n,command_y_n,command_z_n,proxy_x_m,proxy_y_m,proxy_z_m,guard,cause,model_age_s,account_j,"
          "link_total_j\n") {}

void HandTrace::add(const TickFrame& frame, const ProbeReport& report) {
  detail::put_number(rows_, frame.tick);
  rows_ += ',';
  detail::put_number(rows_, frame.t_s);
  rows_ += ',';
  detail::put_number(rows_, report.newest);
  put(rows_, report.command_n);
  put(rows_, report.proxy_m);
  rows_ += std::string(",") + name_of(report.guard) + "," + name_of(report.cause) + ",";
  for (const float value : {report.model_age_s, report.account_j, report.link_total_j}) {
    detail::put_number(rows_, value);
    rows_ += ',';
  }
  rows_.pop_back();
  rows_ += '\n';
  if (rows_.size() < written_at_bytes) return;
  felt_.write(rows_);
  rows_.clear();
}

std::string HandTrace::finish() noexcept {
  try {
    recording_.finish_ticks();
    recording_.finish();
    felt_.write(rows_);
    felt_.finish();
    return {};
  } catch (const std::exception& error) {
    return error.what();
  }
}

}  // namespace palpa::app
