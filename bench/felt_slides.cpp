// Free and tremulous slides, and ends of data.
#include <palpa/study/spectrum.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>

#include "bench/felt.h"
#include "palpa/base/printed.h"
#include "palpa/device/hand.h"

namespace palpa::bench {
namespace {

using detail::text;

struct Slides {
  std::vector<std::vector<Vec3>> commands_n;
  double worst_n = 0.0;  ///< [N] rms above 100 Hz, of a single slide
  double felt_s = 0.0;
  std::map<StepCause, int> steps;
  std::map<std::string, int> modes;  ///< with force steps without an event
};

void count_steps(const FeltRun& run, const FeltScene& felt, double from_s, Slides& into) {
  for (const ExcessStep& step : excess_steps(run, &felt.edges)) {
    if (step.t_s < from_s) continue;
    ++into.steps[step.cause];
    if (!has_event(step.cause) && step.mode >= 0) ++into.modes[run.modes[static_cast<std::size_t>(step.mode)].name];
  }
}

void add_slide(const FeltScene& felt, const HandSlide& slide, Hold hold, Slides& into) {
  const auto hand = hand_device(slide.target, hold);
  const FeltRun run = feel(felt.scene, *hand, slide.to_s);
  count_steps(run, felt, slide.from_s, into);
  into.felt_s += slide.to_s - slide.from_s;
  FeltSignals signals = quiet_signals_of(run, slide.from_s, slide.to_s);
  into.worst_n = std::max(into.worst_n, spectrum_of(signals.command_n, rate_hz).band_rms(rough_low_hz, tactile_high_hz));
  for (std::vector<Vec3>& command_n : signals.command_n) into.commands_n.push_back(std::move(command_n));
}

/// A hand position where data begin or end, and the path through it.
struct Crossing {
  Vec3 place_m, direction;
};
std::vector<Crossing> ends_of_data(const EdgesOfData& edges) {
  constexpr double reach_m = 0.09, look_m = 0.0005;
  constexpr int ways = 200;
  std::mt19937_64 random(17);
  std::uniform_real_distribution<double> place(-reach_m, reach_m);
  std::vector<Crossing> found;
  for (int way = 0; way < ways; ++way) {
    const Vec3 from_m{place(random), place(random), place(random)}, to_m{place(random), place(random), place(random)};
    const Vec3 direction = normalized(to_m - from_m);
    bool had = edges.has_data(from_m);
    for (double gone_m = look_m; gone_m < distance(from_m, to_m); gone_m += look_m) {
      const Vec3 here_m = from_m + gone_m * direction;
      const bool has = edges.has_data(here_m);
      if (has != had) found.push_back({here_m, direction});
      had = has;
    }
  }
  std::shuffle(found.begin(), found.end(), random);
  constexpr std::size_t most = 200;
  if (found.size() > most) found.resize(most);
  return found;
}

/// The steepest change at ends of data, in N/ms; below 0 without an end within reach.
double steepest_at_ends(const FeltScene& felt, Slides& into) {
  constexpr double half_m = 0.02, duration_s = 2.0 * half_m / slide_m_per_s;
  double steepest = -1.0;
  for (const Crossing& crossing : ends_of_data(felt.edges)) {
    const auto through = path_target(
        [crossing](double t_s) { return crossing.place_m + (slide_m_per_s * t_s - half_m) * crossing.direction; }, duration_s);
    const FeltRun run = feel(felt.scene, through, duration_s);
    count_steps(run, felt, 0.0, into);
    into.felt_s += duration_s;
    steepest = std::max(steepest, steepest_at_edges_n_per_ms(run, felt.edges));
  }
  return steepest;
}

std::string format_steps(const Slides& slides) {
  std::string told, unexplained, modes;
  for (const auto& [cause, count] : slides.steps) {
    std::string& words = has_event(cause) ? told : unexplained;
    words += (words.empty() ? "" : ", ") + text("%d ", count) + name_of(cause);
  }
  for (const auto& [mode, count] : slides.modes) modes += (modes.empty() ? "" : ", ") + mode + text(" %d", count);
  if (!modes.empty()) unexplained += " (" + modes + ")";
  if (unexplained.empty()) unexplained = "none";
  return unexplained + (told.empty() ? "" : "; with an event: " + told);
}

/// [s] Time in contact, in segments that are long enough for a window of the spectrum.
double measured_s(const std::vector<std::vector<Vec3>>& commands_n, double window_s) {
  double sum_s = 0.0;
  for (const std::vector<Vec3>& segment : commands_n) {
    const double long_s = static_cast<double>(segment.size()) / rate_hz;
    if (long_s >= window_s) sum_s += long_s;
  }
  return sum_s;
}

/// Ticks near an event of either run count in neither.
void leave_out_events(FeltRun& one, FeltRun& other) {
  const auto is_eventful = [](const FeltTick& tick) { return tick.onset || tick.broke_through || tick.other_event; };
  const auto near = static_cast<std::size_t>(after_break_through_s * rate_hz);
  std::size_t quiet_from = 0;  // ticks before it are done
  for (std::size_t i = 0; i < one.ticks.size(); ++i) {
    if (!is_eventful(one.ticks[i]) && !is_eventful(other.ticks[i])) continue;
    const std::size_t end = std::min(i + near + 1, one.ticks.size());
    for (std::size_t j = std::max(quiet_from, i - std::min(i, near)); j < end; ++j)
      one.ticks[j].usable = other.ticks[j].usable = false;
    quiet_from = end;
  }
}

}  // namespace

std::vector<Figure> slides(const FeltScene& felt) {
  constexpr int directions = 8;
  constexpr double beside = 0.5, width = 1.122;  // the line at the voxel frequency is a third of an octave wide
  Slides all;
  // A rigid hand keeps its path; a relaxed hand stays in contact, and is as rigid above 20 Hz, where the arm's mass does not
  // follow.
  for (const double aside : {-beside, 0.0, beside}) {
    for (int d = 0; d < directions; ++d) {
      const double turn = d / static_cast<double>(directions), rigid_m = aside * felt.rigid.radius_m;
      add_slide(felt, slide_over(felt.rigid, turn, rigid_m, 0.5 * felt.rigid.depth_m), Hold::rigid, all);
      add_slide(felt, slide_over(felt.held, turn, aside * felt.held.radius_m, felt.held.depth_m), Hold::relaxed, all);
    }
  }
  const Spectrum spectrum = spectrum_of(all.commands_n, rate_hz);
  const double rough_n = spectrum.band_rms(rough_low_hz, tactile_high_hz);
  const double voxel_hz = slide_m_per_s / felt.spacing_m, voxel_n = spectrum.band_rms(voxel_hz / width, voxel_hz * width);
  const double edge = steepest_at_ends(felt, all);
  int unexplained = 0;
  for (const auto& [cause, count] : all.steps) unexplained += has_event(cause) ? 0 : count;
  const double per_s = unexplained / all.felt_s;
  const bool measured = spectrum.step_hz > 0.0;
  const char* const nothing = "no contact is long enough";
  return {{.name = "slide at 5 cm/s, 100-500 Hz",
           .measured = measured ? text("%.2f mN, worst slide %.2f, in %.1f s of contact", 1e3 * rough_n, 1e3 * all.worst_n,
                                       measured_s(all.commands_n, 1.0 / spectrum.step_hz))
                                : nothing,
           .asked = "<= 0.5 mN",
           .met = rough_n <= 0.5e-3,
           .badness = rough_n,
           .applies = measured},
          {.name = "slide, at the voxel frequency",
           .measured = measured ? text("%.2f mN at %.0f Hz", 1e3 * voxel_n, voxel_hz) : nothing,
           .asked = "<= 3 mN",
           .met = voxel_n <= 3e-3,
           .badness = voxel_n,
           // Below the tactile band, voxels are as large as shapes that hands follow.
           .applies = measured && voxel_hz >= tactile_low_hz && voxel_hz < tactile_high_hz},
          {.name = "excess steps > 50 mN without event",
           .measured = text("%.2f /s: ", per_s) + format_steps(all),
           .asked = "0",
           .met = unexplained == 0,
           .badness = per_s},
          {.name = "steepest at an end of data, 5 cm/s",
           .measured = edge < 0.0 ? "no end within reach" : text("%.3f N/ms", edge),
           .asked = "<= 0.1 N/ms",
           .met = edge <= 0.1,
           .badness = edge,
           .applies = edge >= 0.0}};
}

std::vector<Figure> tremor(const FeltScene& felt) {
  constexpr double duration_s = even_s + 2.1, encoder_step_m = 55e-6;
  DevicePlant encoder{.name = "encoder"};
  encoder.limits.encoder_step_m = encoder_step_m;
  const auto band_n = [](const std::vector<std::vector<Vec3>>& forces_n) {
    return spectrum_of(forces_n, rate_hz).band_rms(tactile_low_hz, tactile_high_hz);
  };
  double own_n = 0.0, worst = 0.0;
  for (const double tremor_m : {1e-4, 3e-4, 5e-4}) {
    for (const double tremor_hz : {8.3, 10.1, 11.7}) {
      const auto target = hold_at(felt.rigid, 0.0, felt.rigid.depth_m, {tremor_m, tremor_hz}, duration_s);
      FeltRun without = feel(felt.scene, target, duration_s), with = feel(felt.scene, target, duration_s, encoder);
      // Friction's force crosses zero at a reversal without loss of contact: both runs count away from events.
      leave_out_events(without, with);
      const FeltSignals smooth = signals_of(without, even_s, duration_s), stepped = signals_of(with, even_s, duration_s);
      own_n = std::max(own_n, band_n(smooth.command_n));
      // The tremor's own reversals of friction are not the encoder's effect.
      const double force_n = band_n(stepped.command_n), of_tremor_n = band_n(smooth.command_n);
      if (const double spring_n = band_n(stepped.spring_n); spring_n > 0.0)
        worst = std::max(worst, std::sqrt(std::max(0.0, force_n * force_n - of_tremor_n * of_tremor_n)) / spring_n);
    }
  }
  const bool measured = worst > 0.0;
  const char* const nothing = "no tremor stays in contact";
  return {{.name = "tremor 0.1-0.5 mm, 8-12 Hz, 20-500 Hz",
           .measured = measured ? text("%.1f mN", 1e3 * own_n) : nothing,
           .badness = own_n,
           .applies = measured},
          {.name = "tremor, encoder 55 um: force / (k probe)",
           .measured = measured ? text("%.3f", worst) : nothing,
           .asked = "<= 1.1",
           .met = worst <= 1.1,
           .badness = worst,
           .applies = measured}};
}

}  // namespace palpa::bench
