// What happened over time: plots that a page can zoom, and that paper shows as they are.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "palpa/report/recorded.h"
#include "palpa/view/plot.h"

namespace palpa::detail {

/// A plot over the time of a trace; all series have the same times.
struct TimePlot {
  std::string id;  ///< letters; also the name of its file
  Plot plot;
  std::string label;    ///< what it shows, for those who do not see it
  std::string caption;  ///< how it is read
};

/// A curve over the times of ticks. \param value  of the tick of a number
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

/// Force on the hand, force of each mode, distance of proxy and probe, energy, time inside the tick (where it was measured).
std::vector<TimePlot> time_plots(const Recorded& recorded);

/// The plots as JSON for plots.js. Long ones are thinned to `most_rows` [rows] or a little more, so that the lowest and the
/// highest value of each series in every part of the time stay, and the rows `always`.
std::string json_of(const std::vector<TimePlot>& plots, std::size_t most_rows, const std::vector<std::size_t>& always);

}  // namespace palpa::detail
