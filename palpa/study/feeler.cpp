#include "palpa/study/feeler.h"

#include <algorithm>
#include <limits>

#include "palpa/loop/window_policy.h"

namespace palpa::detail {

void feel_octave_of_search(Session& session) {
  Stock& stock = session.stock();
  constexpr std::int64_t most_voxels = 256;  // along an axis. More: a slower start of runs; fewer: places are rougher
  int octave = 0;
  for (std::size_t n = 0; n < stock.size(); ++n) {
    const Octaves& octaves = stock.octaves(n);
    int own = 0;
    while (own < octaves.count() - 1 && std::ranges::max(octaves.dims(own)) > most_voxels) ++own;
    octave = std::max(octave, own);
  }
  stock.set_finest(octave);
  for (std::size_t n = 0; n < stock.size(); ++n) {
    const Octaves& octaves = stock.octaves(n);
    const WindowPlace all{&octaves, octave, {}, octaves.sampled_grid(octave).dims};
    if (can_be_felt_live(all)) stock.lay(n, octave, octaves.window(octave, all.first, all.dims));
  }
}

std::vector<std::unique_ptr<Feeler>> feelers(const Scene& scene) {
  std::vector<std::unique_ptr<Feeler>> all;
  for (std::size_t n = 0; n < feeling_threads(); ++n) all.push_back(std::make_unique<Feeler>(scene));
  return all;
}

double share_of_disc(const Ways& ways, int column, int row, double radius) {
  const int reach = static_cast<int>(std::ceil(radius));
  int felt = 0, all = 0;
  for (int j = row - reach; j <= row + reach; ++j)
    for (int i = column - reach; i <= column + reach; ++i) {
      const double di = i - column, dj = j - row;
      if (di * di + dj * dj > radius * radius + 1e-9) continue;
      ++all;
      felt += i >= 0 && j >= 0 && i < ways.columns && j < ways.rows && ways.at(i, j).onset_m;
    }
  return static_cast<double>(felt) / all;
}

double slope_of_disc(const Ways& ways, int column, int row, double radius, double spacing_m) {
  const int reach = static_cast<int>(std::ceil(radius));
  double sum = 0.0, all = 0.0;
  for (int j = std::max(0, row - reach); j <= std::min(ways.rows - 1, row + reach); ++j)
    for (int i = std::max(0, column - reach); i <= std::min(ways.columns - 1, column + reach); ++i) {
      const double away = std::hypot(i - column, j - row);
      if (away == 0.0 || away > radius || !ways.at(i, j).onset_m) continue;
      sum += std::min(2.0, std::abs(*ways.at(i, j).onset_m - *ways.at(column, row).onset_m) / (away * spacing_m));
      ++all;
    }
  return all > 0.0 ? sum / all : 0.0;
}

std::vector<double> filled(const Ways& ways, const std::function<double(const Way&)>& value) {
  constexpr double none = std::numeric_limits<double>::quiet_NaN();
  std::vector<double> heights;
  for (const Way& way : ways.way) heights.push_back(way.onset_m ? value(way) : none);
  const auto at = [&](int i, int j) {
    if (ways.turns) i = (i + ways.columns) % ways.columns;
    if (i < 0 || j < 0 || i >= ways.columns || j >= ways.rows) return none;
    return heights[static_cast<std::size_t>(j * ways.columns + i)];
  };
  for (bool filled_any = true; filled_any;) {
    filled_any = false;
    std::vector<double> next = heights;
    for (int j = 0; j < ways.rows; ++j)
      for (int i = 0; i < ways.columns; ++i) {
        double& here = next[static_cast<std::size_t>(j * ways.columns + i)];
        if (!std::isnan(here)) continue;
        double sum = 0.0;
        int count = 0;
        for (const double beside : {at(i - 1, j), at(i + 1, j), at(i, j - 1), at(i, j + 1)}) {
          if (!std::isnan(beside)) sum += beside, ++count;
        }
        if (count > 0) here = sum / count, filled_any = true;
      }
    heights = std::move(next);
  }
  return heights;
}

}  // namespace palpa::detail
