#include "app/check_picture.h"

#include "palpa/view/plot.h"

namespace palpa::app {

void draw_check(const CheckReport& report, const std::filesystem::path& file, detail::Existing existing) {
  Plot plot{.title = "Which k and D are stable: " + report.plant.name,
            .x_label = "k / (N/m)",
            .y_label = "D / (N·s/m)",
            .x_range = std::pair{40.0, 6000.0},
            .y_range = std::pair{-0.15, 4.15},
            .x_log = true};
  struct Kind {
    Grade grade;
    const char* name;
    CurveColor color;
  };
  constexpr Kind kinds[] = {{Grade::fine, "stable when released", CurveColor::sky},
                            {Grade::warn, "hums", CurveColor::orange},
                            {Grade::stop, "shakes", CurveColor::vermilion}};
  for (const Kind& kind : kinds) {
    Series series{.name = kind.name, .color = kind.color, .points_only = true};
    for (const MarginPoint& point : report.map) {
      if (point.grade != kind.grade) continue;
      series.xs.push_back(point.stiffness_n_per_m);
      series.ys.push_back(point.damping_ns_per_m);
    }
    if (!series.xs.empty()) plot.series.push_back(std::move(series));
  }
  const auto curve = [&](const char* name, CurveColor color, Stroke stroke, auto stiffness_of) {
    Series series{.name = name, .color = color, .stroke = stroke};
    for (const StableStiffness& stable : report.curve) {
      series.xs.push_back(stiffness_of(stable));
      series.ys.push_back(stable.damping_ns_per_m);
    }
    plot.series.push_back(std::move(series));
  };
  curve("wall, with friction", CurveColor::green, Stroke::solid, [](const StableStiffness& s) { return s.friction_n_per_m; });
  curve("wall, without", CurveColor::blue, Stroke::solid, [](const StableStiffness& s) { return s.alone_n_per_m; });
  curve("bound (b + D)/(T/2 + delay)", CurveColor::grey, Stroke::dashed,
        [](const StableStiffness& s) { return s.bounds.stable_n_per_m; });
  plot.series.push_back({.name = "this scene",
                         .xs = {report.coupling.stiffness_n_per_m},
                         .ys = {report.coupling.damping_ns_per_m},
                         .color = CurveColor::black,
                         .points_only = true});
  detail::write_whole(file, png_of(picture_of(plot, 900, 520)), existing);
}

}  // namespace palpa::app
