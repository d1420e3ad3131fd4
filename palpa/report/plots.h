// Plots over time: zoomable in a page, static on paper.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "palpa/report/recorded.h"
#include "palpa/view/plot.h"

namespace palpa::detail {

/// Plot over the time of a trace; all series share their times.
struct TimePlot {
  std::string id;  ///< letters; also its file name
  Plot plot;
  std::string label;    ///< text alternative
  std::string caption;  ///< explanation for the reader
};

/// Curve over the times of ticks. \param value  function of a tick's index
Series over_time(const auto& ticks, std::string name, palpa::CurveColor color, Stroke stroke, const auto& value) {
  Series series{.name = std::move(name), .color = color, .stroke = stroke};
  series.xs.reserve(ticks.size());
  series.ys.reserve(ticks.size());
  for (std::size_t i = 0; i < ticks.size(); ++i) {
    series.xs.push_back(ticks[i].t_s);
    series.ys.push_back(value(i));
  }
  return series;
}

/// Force on the hand, torque (of a tool), force of each mode, distance of proxy and probe, energy, duration of the tick (if
/// measured).
std::vector<TimePlot> time_plots(const Recorded& recorded);

/// Plots as JSON for plots.js. Long plots are thinned to about `most_rows` [rows], keeping the minimum and maximum of each
/// series in every interval, and the rows `always`.
std::string json_of(const std::vector<TimePlot>& plots, std::size_t most_rows, const std::vector<std::size_t>& always);

}  // namespace palpa::detail
