// The pictures of bench_felt: a sheet for each scene.
#include <palpa/report/signal.h>
#include <palpa/study/spectrum.h>
#include <palpa/view/plot.h>

#include "bench/felt.h"
#include "palpa/base/printed.h"

namespace palpa::bench {
namespace {

using detail::text;

/// Magnitude of the command over time; time 0 is `from_s`.
Series force_over_time(const FeltRun& run, const std::string& name, CurveColor color, double from_s) {
  Series series{.name = name, .color = color};
  for (const FeltTick& tick : run.ticks) {
    if (tick.t_s < from_s) continue;
    series.xs.push_back(tick.t_s - from_s);
    series.ys.push_back(norm(tick.command_n));
  }
  return series;
}

/// Of the slides that stay on their surface, the slide with the largest force.
HandSlide firmest_slide(const FeltScene& felt) {
  constexpr int directions = 8;
  HandSlide best = slide_over(felt.held, 0.0, 0.0, felt.held.depth_m);
  double most = 0.0;
  for (int d = 0; d < directions; ++d) {
    const HandSlide slide = slide_over(felt.held, d / static_cast<double>(directions), 0.0, felt.held.depth_m);
    const auto hand = hand_device(slide.target, Hold::relaxed);
    double sum = 0.0;
    for (const auto& stretch : quiet_signals_of(feel(felt.scene, *hand, slide.to_s), slide.from_s, slide.to_s).command_n) {
      for (const Vec3& force_n : stretch) sum += norm(force_n);
    }
    if (sum <= most) continue;
    most = sum;
    best = slide;
  }
  return best;
}

/// Events, and force steps without an event.
std::vector<Mark> marks_of(const FeltRun& run, const EdgesOfData& edges, double from_s) {
  std::vector<Mark> marks;
  for (const FeltTick& tick : run.ticks) {
    if (tick.t_s < from_s) continue;
    if (tick.broke_through)
      marks.push_back({tick.t_s - from_s, "break-through"});
    else if (tick.onset)
      marks.push_back({tick.t_s - from_s, "level met"});
  }
  for (const ExcessStep& step : excess_steps(run, &edges)) {
    if (step.t_s >= from_s && !has_event(step.cause)) marks.push_back({step.t_s - from_s, "step without event"});
  }
  return marks;
}

Plot spectra(const FeltScene& felt, const HandSlide& slide, const FeltRun& smooth, const FeltRun& stepped) {
  const FeltSignals own = signals_of(smooth, slide.from_s, slide.to_s), device = signals_of(stepped, slide.from_s, slide.to_s);
  Plot plot = detail::spectrum_plot(
      "Its spectrum: what skin feels as rough lies between 20 and 500 Hz",
      {detail::amplitudes(spectrum_of(device.spring_n, rate_hz), "k \u00b7 probe, encoder 55 \u00b5m", CurveColor::orange,
                          Stroke::dashed),
       detail::amplitudes(spectrum_of(device.command_n, rate_hz), "force, encoder 55 \u00b5m", CurveColor::vermilion,
                          Stroke::solid),
       detail::amplitudes(spectrum_of(own.command_n, rate_hz), "force, no encoder", CurveColor::blue, Stroke::solid)});
  constexpr double seen_hz = 4.0;  // from the spectrum's second point on
  const double voxel_hz = slide_m_per_s / felt.spacing_m;
  if (voxel_hz > seen_hz && voxel_hz < tactile_high_hz) plot.marks.push_back({voxel_hz, text("voxels, %.0f Hz", voxel_hz)});
  return plot;
}

Plot press(const FeltScene& felt) {
  constexpr double press_m_per_s = 0.02;
  const double beside_m = 0.5 * felt.rigid.radius_m, duration_s = press_duration_s(felt.rigid, press_m_per_s);
  FeltRun best;
  double most = -1.0;
  for (const auto& [u_m, v_m] : {std::pair{0.0, 0.0}, {beside_m, 0.0}, {-beside_m, 0.0}, {0.0, beside_m}, {0.0, -beside_m}}) {
    FeltRun run = feel(felt.scene, press_at(felt.rigid, u_m, v_m, press_m_per_s), duration_s);
    double sum = 0.0;
    for (const FeltTick& tick : run.ticks) sum += norm(tick.command_n);
    if (sum <= most) continue;
    most = sum;
    best = std::move(run);
  }
  const double fall = steepest_fall_n_per_ms(best);
  return {.title = "Pressed in at 2 cm/s; " +
                   (fall > 0.0 ? text("the steepest fall at a break-through: %.2f N/ms", fall) : std::string("nothing breaks")),
          .x_label = "time / s",
          .y_label = "force on the hand / N",
          .series = {force_over_time(best, "", CurveColor::black, 0.0)},
          .marks = marks_of(best, felt.edges, 0.0)};
}

Plot held_still(const FeltScene& felt) {
  constexpr double duration_s = even_s + 0.5;
  Plot plot{.title = "Held still by a relaxed hand, without Coulomb friction: force less its mean",
            .x_label = "time / s",
            .y_label = "force / mN"};
  constexpr CurveColor colors[] = {CurveColor::blue, CurveColor::vermilion, CurveColor::green, CurveColor::purple,
                                   CurveColor::orange};
  std::size_t next = 0;
  for (DevicePlant plant : device_plants()) {
    plant.coulomb_friction_n = 0.0;
    const auto hand = hand_device(hold_at(felt.held, 0.0, felt.held.depth_m, {}, duration_s), Hold::relaxed, plant);
    Series series = force_over_time(feel(felt.scene, *hand, duration_s), plant.name, colors[next++], even_s);
    double mean_n = 0.0;
    if (next > 3) series.stroke = Stroke::dashed;  // curves that coincide stay visible
    for (const double force_n : series.ys) mean_n += force_n / static_cast<double>(series.ys.size());
    for (double& force_n : series.ys) force_n = 1e3 * (force_n - mean_n);
    plot.series.push_back(std::move(series));
  }
  return plot;
}

}  // namespace

void save_felt_picture(const FeltScene& felt, const std::filesystem::path& file) {
  constexpr int width_px = 1800, height_px = 1100;
  constexpr double encoder_step_m = 55e-6;
  DevicePlant encoder{.name = "encoder"};
  encoder.limits.encoder_step_m = encoder_step_m;
  const HandSlide slide = firmest_slide(felt);
  const auto hand = hand_device(slide.target, Hold::relaxed), in_device = hand_device(slide.target, Hold::relaxed, encoder);
  const FeltRun smooth = feel(felt.scene, *hand, slide.to_s), stepped = feel(felt.scene, *in_device, slide.to_s);
  Plot slid{.title = felt.name + ": a relaxed hand slides at 5 cm/s",
            .x_label = "time / s",
            .y_label = "force on the hand / N",
            .series = {force_over_time(stepped, "encoder 55 \u00b5m", CurveColor::vermilion, slide.from_s),
                       force_over_time(smooth, "no encoder", CurveColor::blue, slide.from_s)},
            .marks = marks_of(smooth, felt.edges, slide.from_s)};
  const Sheet sheet{.columns = 2, .panels = {slid, spectra(felt, slide, smooth, stepped), press(felt), held_still(felt)}};
  save_png(picture_of(sheet, width_px, height_px), file);
}

}  // namespace palpa::bench
