#include "palpa/view/volume_picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>

#include "palpa/base/printed.h"
#include "palpa/base/wording.h"
#include "palpa/data/ct.h"
#include "palpa/data/derived.h"
#include "palpa/data/labels.h"
#include "palpa/data/length_unit.h"
#include "palpa/data/octave_parts.h"
#include "palpa/data/volume.h"
#include "palpa/scene/first_flow.h"
#include "palpa/scene/first_levels.h"
#include "palpa/view/canvas.h"
#include "palpa/view/colors.h"
#include "palpa/view/offscreen.h"
#include "palpa/view/picture.h"
#include "palpa/view/plot.h"

namespace palpa {
namespace {

using detail::Canvas;
using detail::ColorMap;
using detail::Side;

/// Orientation of a slice in the picture: two axes of the world with signs.
struct Cut {
  const char* name;
  int across, right, up;       ///< axes of the world: 0, 1, 2
  double right_sign, up_sign;  ///< [1] 1 or -1
};

// Radiological convention: from the feet, from the front, from the patient's left.
constexpr std::array<Cut, 3> medical_cuts{{{"axial", 2, 0, 1, 1, -1}, {"coronal", 1, 0, 2, 1, 1}, {"sagittal", 0, 1, 2, 1, 1}}};
constexpr std::array<Cut, 3> plain_cuts{
    {{"across z", 2, 0, 1, 1, 1}, {"across y", 1, 0, 2, 1, 1}, {"across x", 0, 1, 2, 1, 1}}};

double part(const Vec3& v, int axis) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }
Vec3 along(int axis) { return {axis == 0 ? 1.0 : 0.0, axis == 1 ? 1.0 : 0.0, axis == 2 ? 1.0 : 0.0}; }

std::string direction_words(bool medical, int axis, double sign) {
  static constexpr const char* letters[] = {"L", "R", "P", "A", "S", "I"};
  static constexpr const char* axes[] = {"x", "-x", "y", "-y", "z", "-z"};
  const std::size_t number = 2 * static_cast<std::size_t>(axis) + (sign < 0.0 ? 1 : 0);
  return medical ? letters[number] : axes[number];
}

std::string millimetre_words(double m) { return detail::text("%.1f mm", 1e3 * std::abs(m)); }

/// Second window: bone after windows of soft parts, soft tissue after bone and lung.
CtWindow beside(const CtWindow& window) {
  if (window.width >= 1000.0) return {"soft tissue", 40, 400};
  return {"bone", 400, 1800};
}

struct Rgb {
  std::uint8_t red, green, blue;
};
Rgb rgb(const detail::Color& c) {
  const auto byte = [](double x) { return static_cast<std::uint8_t>(std::lround(255.0 * std::clamp(x, 0.0, 1.0))); };
  return {byte(c.red), byte(c.green), byte(c.blue)};
}

void set_pixel(Picture& picture, int x, int y, const Rgb& color) {
  if (x < 0 || y < 0 || x >= picture.width_px || y >= picture.height_px) return;
  std::uint8_t* at = picture.rgb.data() + 3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(picture.width_px) +
                                               static_cast<std::size_t>(x));
  at[0] = color.red, at[1] = color.green, at[2] = color.blue;
}

void paste(Picture& onto, const Picture& part, int left, int top) {
  for (int y = 0; y < part.height_px; ++y)
    for (int x = 0; x < part.width_px; ++x) {
      const std::uint8_t* from = part.rgb.data() + 3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(part.width_px) +
                                                        static_cast<std::size_t>(x));
      set_pixel(onto, left + x, top + y, {from[0], from[1], from[2]});
    }
}

/// Rectangle in pixels from the upper left corner.
struct Place {
  int left, top, width, height;
};

/// Colours of slices.
struct Shades {
  ColorMap colors;
  std::string words;        ///< beside the bar: "brain window"; may be empty
  bool labels = false;      ///< values name parts: never blended
  bool directions = false;  ///< red, green and blue are the magnitudes of a direction's x, y and z
};

Shades ct_shades(const CtWindow& window, double water) {
  const double low = water + window.level - 0.5 * window.width;
  return {detail::grey_colors(low, low + window.width),
          detail::text("%s window, W %g L %g", window.name, window.width, window.level)};
}

/// Width of a label's colour to either side of its number. 0.5: adjacent colours meet at one ambiguous point of the map; less:
/// colours between labels are blends.
constexpr double half_label = 0.4999;

/// Colour map of labels: hues a golden angle apart, so that neighbours differ, alternately dark and light; the background is
/// nearly black.
ColorMap label_colors(const LabelMap& map) {
  std::map<double, std::string> colors{{map.background, "#101010"}};
  for (const Label& label : map.labels) colors[label.value] = {};
  int number = 0;
  std::vector<ViewLayer::ColorPoint> points;
  for (auto& [value, hex] : colors) {
    if (hex.empty()) {
      const double hue = std::fmod(0.618034 * ++number, 1.0), light = number % 2 == 0 ? 0.95 : 0.7;
      const auto channel = [&](double shift) {
        const double ramp = std::clamp(std::abs(std::fmod(hue + shift, 1.0) * 6.0 - 3.0) - 1.0, 0.0, 1.0);
        return static_cast<int>(std::lround(255.0 * light * (0.35 + 0.65 * ramp)));
      };
      hex = detail::text("#%02x%02x%02x", static_cast<unsigned>(channel(0.0)), static_cast<unsigned>(channel(2.0 / 3.0)),
                         static_cast<unsigned>(channel(1.0 / 3.0)));
    }
    points.push_back({value - half_label, hex, 1.0}), points.push_back({value + half_label, hex, 1.0});
  }
  return ColorMap(points);
}

/// First colours of a field, and the second window of a CT.
struct Shown {
  Shades first;
  std::optional<Shades> second;
};

Shown shown_as(const Volume& volume, const VolumeField& shown, const Statistics& values) {
  const Field& field = *shown.field;
  const Histogram& h = values.histogram;
  if (field.components() == 3 && looks_like_directions(values)) {
    const bool medical = volume.medical_frame;
    return {{ColorMap({{0, "#ff0000", 1},
                       {0.999, "#ff0000", 1},
                       {1, "#00ff00", 1},
                       {1.999, "#00ff00", 1},
                       {2, "#0000ff", 1},
                       {3, "#0000ff", 1}}),
             medical ? "left-right, front-back, head-feet" : "along x, y, z", false, true},
            {}};
  }
  if (field.components() == 3)
    return {{detail::magnitude_colors(0.0, std::max(detail::first_flow(values).fast, 1e-300)), ""}, {}};
  if (const LabelMap map = label_map_unless_said(field, values, shown.unit, volume.modality); !map.labels.empty()) {
    return {{label_colors(map), "labels", true}, {}};
  }
  if (const auto water = ct_water(values, shown.unit, volume.modality)) {
    std::string body_part;
    for (const ScanFact& fact : volume.scan) {
      if (fact.kind == ScanFactKind::body_part) body_part = fact.words;
    }
    const CtWindow window = ct_window(values, *water, body_part, largest_component(field.bounds_m().size_m()));
    return {ct_shades(window, *water), ct_shades(beside(window), *water)};
  }
  const double span = values.max - values.min;
  const double low = detail::rounded(h.percentile(0.005), span), high = detail::rounded(h.percentile(0.995), span);
  return {
      {high > low ? detail::grey_colors(low, high) : detail::grey_colors(values.min, std::max(values.max, values.min + 1.0)),
       ""},
      {}};
}

class Slices {
 public:
  Slices(const Volume& volume, const Field& field, Shades shades, const Place& place, double em_px)
      : field_(field),
        medical_(volume.medical_frame),
        file_unit_m_(file_unit_m(volume)),
        box_(field.bounds_m()),
        shades_(std::move(shades)),
        cuts_(medical_ ? medical_cuts : plain_cuts),
        em_px_(em_px) {
    const double width_px = place.width / 3.0 - 4.0 * em_px, height_px = place.height - 3.0 * em_px;
    px_per_m_ = 1e300;
    for (const Cut& cut : cuts_) {
      const Vec3 size_m = box_.size_m();
      px_per_m_ = std::min(px_per_m_, width_px / std::max(part(size_m, cut.right), 1e-300));
      px_per_m_ = std::min(px_per_m_, height_px / std::max(part(size_m, cut.up), 1e-300));
    }
    for (std::size_t c = 0; c < 3; ++c) {
      const int width = std::max(1, static_cast<int>(px_per_m_ * part(box_.size_m(), cuts_[c].right)));
      const int height = std::max(1, static_cast<int>(px_per_m_ * part(box_.size_m(), cuts_[c].up)));
      const int middle_x = place.left + static_cast<int>(place.width * (2.0 * static_cast<double>(c) + 1.0) / 6.0);
      const int middle_y = place.top + static_cast<int>(2.0 * em_px + 0.5 * height_px);
      places_[c] = {middle_x - width / 2, middle_y - height / 2, width, height};
    }
  }

  const Shades& shades() const { return shades_; }
  double px_per_m() const { return px_per_m_; }

  void draw_words(Canvas& canvas) const {
    const auto up_px = [&](double y) { return canvas.height_px() - y; };
    for (std::size_t c = 0; c < 3; ++c) {
      const Cut& cut = cuts_[c];
      const Place& p = places_[c];
      const double x = p.left + 0.5 * p.width, y = up_px(p.top + 0.5 * p.height);
      const double at_m = part(box_.centre_m(), cut.across);
      const double unit_m = largest_component(box_.size_m());
      const bool is_zero = std::abs(at_m) < 1e-6 * unit_m;  // up to rounding
      const std::string where = medical_ ? direction_words(true, cut.across, at_m) + " " + millimetre_words(at_m)
                                         : std::string(1, "xyz"[cut.across]) + " = " + (at_m < 0.0 && !is_zero ? "-" : "") +
                                               (is_zero ? "0" : detail::length_words(std::abs(at_m), unit_m, file_unit_m_));
      canvas.text(std::string(cut.name) + ", " + where, x, up_px(p.top) + 1.6 * em_px_, Side::middle, 0.9, true);
      canvas.text(direction_words(medical_, cut.right, cut.right_sign), p.left + p.width + 0.5 * em_px_, y, Side::left);
      canvas.text(direction_words(medical_, cut.right, -cut.right_sign), p.left - 0.5 * em_px_, y, Side::right);
      canvas.text(direction_words(medical_, cut.up, cut.up_sign), x, up_px(p.top) + 0.65 * em_px_, Side::middle, 0.8);
      canvas.text(direction_words(medical_, cut.up, -cut.up_sign), x, up_px(p.top + p.height) - 0.8 * em_px_, Side::middle,
                  0.8);
    }
  }

  void paint(Picture& picture) const {
    for (std::size_t c = 0; c < 3; ++c) paint(picture, cuts_[c], places_[c], shades_, px_per_m_);
  }
  /// The first slice again, in other colours, as large as fits.
  void paint_again(Picture& picture, const Shades& shades, const Place& within) const {
    const Cut& cut = cuts_[0];
    const double width_m = part(box_.size_m(), cut.right), height_m = part(box_.size_m(), cut.up);
    const double px_per_m = std::min(within.width / std::max(width_m, 1e-300), within.height / std::max(height_m, 1e-300));
    const int width = std::max(1, static_cast<int>(px_per_m * width_m)),
              height = std::max(1, static_cast<int>(px_per_m * height_m));
    paint(picture, cut, {within.left + (within.width - width) / 2, within.top + (within.height - height) / 2, width, height},
          shades, px_per_m);
  }
  const char* first_name() const { return cuts_[0].name; }

 private:
  void paint(Picture& picture, const Cut& cut, const Place& p, const Shades& shades, double px_per_m) const {
    const Vec3 middle_m = box_.centre_m();
    for (int y = 0; y < p.height; ++y)
      for (int x = 0; x < p.width; ++x) {
        const double right_m = cut.right_sign * (x + 0.5 - 0.5 * p.width) / px_per_m;
        const double up_m = cut.up_sign * (0.5 * p.height - y - 0.5) / px_per_m;
        const Vec3 at_m = middle_m + right_m * along(cut.right) + up_m * along(cut.up);
        bool inside = false;
        detail::Color color;
        if (field_.components() == 1) {
          const ScalarSample sample = field_.scalar(shades.labels ? nearest_voxel(at_m) : at_m);
          inside = sample.inside, color = shades.colors.at(sample.value).color;
        } else {
          // Adjacent directions may have opposite signs: do not blend.
          const VectorSample sample = field_.vector(shades.directions ? nearest_voxel(at_m) : at_m);
          inside = sample.inside;
          color = shades.directions
                      ? detail::Color{std::abs(sample.value.x), std::abs(sample.value.y), std::abs(sample.value.z)}
                      : shades.colors.at(norm(sample.value)).color;
        }
        const double pale = (x / 6 + y / 6) % 2 == 0 ? 0.93 : 0.86;
        set_pixel(picture, p.left + x, p.top + y, rgb(inside ? color : detail::Color{pale, pale, 1.0}));
      }
  }

  /// Centre of the nearest voxel; the position itself if planes are unevenly spaced.
  Vec3 nearest_voxel(const Vec3& at_m) const {
    const GridView* grid = grid_behind(field_);
    if (!grid || grid->geometry.is_rectilinear()) return at_m;
    const Vec3 at = inverse(grid->geometry.index_to_world_m) * (at_m - grid->geometry.origin_m);
    return grid->geometry.to_world({std::round(at.x), std::round(at.y), std::round(at.z)});
  }

  const Field& field_;
  bool medical_;
  double file_unit_m_;
  Box box_;
  Shades shades_;
  std::array<Cut, 3> cuts_;
  double em_px_;
  double px_per_m_ = 1.0;
  std::array<Place, 3> places_{};
};

Picture histogram_picture(const Statistics& values, const std::string& label, int width_px, int height_px) {
  const Histogram shown = values.histogram.in_classes(128);
  Series steps{.name = {}, .color = CurveColor::blue};
  // Zero has no logarithm: an empty class is drawn as half a voxel.
  const double all = static_cast<double>(std::max<std::int64_t>(1, values.counted));
  const double least = 50.0 / all;
  for (std::size_t c = 0; c < shown.counts.size(); ++c) {
    const double percent = std::max(least, 100.0 * static_cast<double>(shown.counts[c]) / all);
    for (const double x : {shown.edge(c), shown.edge(c + 1)}) steps.xs.push_back(x), steps.ys.push_back(percent);
  }
  Plot plot;
  plot.title = "Histogram";
  plot.x_label = detail::in_letters_of_font(label);
  plot.y_label = "voxels / %";
  plot.series = {steps};
  plot.y_range = {{least, 100.0}};
  plot.y_log = true;
  return picture_of(plot, width_px, height_px);
}

/// Vector field restricted to positions where it is coherent with its neighbourhood; the rest is noise.
class CoherentFlow : public Field {
 public:
  explicit CoherentFlow(FieldPtr flow) : flow_(std::move(flow)), coherence_(derived(Derivation::coherence, flow_)) {}
  int components() const noexcept override { return flow_->components(); }
  VectorSample vector(const Vec3& x_m) const noexcept override {
    VectorSample sample = flow_->vector(x_m);
    const ScalarSample coherence = coherence_->scalar(x_m);
    sample.inside = sample.inside && coherence.inside && coherence.value >= detail::coherence_of_flow;
    return sample;
  }
  double spacing_m() const noexcept override { return flow_->spacing_m(); }
  Box bounds_m() const noexcept override { return flow_->bounds_m(); }
  double depth_m(const Vec3& x_m) const noexcept override { return flow_->depth_m(x_m); }
  std::vector<ValueRange> value_ranges() const override { return flow_->value_ranges(); }

 private:
  FieldPtr flow_, coherence_;
};

/// The field without noise, if a suggested scene would mask noise.
FieldPtr without_noise(const Volume& one, const Statistics& values) {
  const FieldPtr& flow = one.fields.front().field;
  const detail::FirstFlow speeds = detail::first_flow(values);
  if (speeds.directions || !(largest_component(flow->bounds_m().size_m()) > 0.0)) return flow;
  const detail::FlowPlaces places = detail::flow_places(detail::Lattice(flow->bounds_m()), one, 0, speeds, {values});
  return places.noisy ? std::make_shared<CoherentFlow>(flow) : flow;
}

/// Streamlines of the field, as in a scene. \param values  its statistics
Picture streamline_picture(const Volume& volume, std::size_t field, const Statistics& values, int width_px, int height_px) {
  Scene scene;
  Volume one = volume;
  one.fields = {volume.fields[field]};
  one.fields.front().field = without_noise(one, values);
  const std::string name = detail::is_plain_word(one.fields.front().name) ? one.fields.front().name : "flow";
  const FieldRef flow = scene.add(name, std::move(one));
  Workspace workspace{.fit = name};
  if (!volume.medical_frame) workspace.towards_user = "-y", workspace.up = "+z";
  scene.set(workspace);
  scene.layers = {{.show = ViewLayer::Show::streamlines, .field = flow}};
  return scene_picture(scene, {}, {}, {.width_px = width_px, .height_px = height_px});
}

// All colours of a map from left to right.
void paint_bar(Picture& picture, const ColorMap& colors, int left, int top, double width, int height) {
  for (int x = 0; x < static_cast<int>(width); ++x) {
    const double value = colors.low() + (x + 0.5) / width * (colors.high() - colors.low());
    for (int y = 0; y < height; ++y) set_pixel(picture, left + x, top + y, rgb(colors.at(value).color));
  }
}

}  // namespace

double file_unit_m(const Volume& volume) {
  if (!volume.length_unit_assumed || volume.medical_frame) return 0.0;
  const auto assumed = detail::length_unit(volume.length_unit);
  return assumed ? assumed->metres : 1.0;
}

double file_unit_m(const Scene& scene) {
  double found_m = 0.0;
  for (const SceneVolume& volume : scene.volumes()) {
    const double unit_m = file_unit_m(volume.volume);
    if (unit_m == 0.0 || (found_m > 0.0 && unit_m != found_m)) return 0.0;
    found_m = unit_m;
  }
  return found_m;
}

namespace {

/// The field as it is drawn: of a field in octaves one with about a voxel a pixel, which its title names.
FieldPtr drawn_in(const FieldPtr& field, int pixels, std::string& title, double file_unit_m) {
  const Box box = field->bounds_m();
  const double side_m = largest_component(box.size_m());
  const auto drawn = side_m > 0.0 ? drawn_octave(*field, {}, box, side_m / pixels) : std::nullopt;
  if (!drawn) return field;
  title +=
      ", octave " + std::to_string(drawn->octave) + ": voxels of " + detail::length_words(drawn->voxel_m, 0.0, file_unit_m);
  return drawn->field;
}

}  // namespace

Picture volume_picture(const Volume& whole, std::size_t number, const Statistics& values, const std::string& of_file,
                       const VolumePictureOptions& options) {
  const int width = options.width_px, height = options.height_px;
  detail::check_size(width, height, 600, 400);
  Volume volume = whole;
  std::string title = of_file;
  volume.fields[number].field = drawn_in(whole.fields[number].field, width / 3, title, file_unit_m(whole));
  const VolumeField& shown = volume.fields[number];
  const bool flow = shown.field->components() == 3;
  const std::string label = (flow ? "length of " : "") + shown.name + (shown.unit.empty() ? "" : " / " + shown.unit);

  detail::OffscreenWindow window(width, height);
  Canvas canvas(window.white(), width, height);
  const double em = canvas.em_px();
  const int lower_top = static_cast<int>(0.60 * height);
  const Shown as = shown_as(volume, shown, values);
  const Slices slices(volume, *shown.field, as.first,
                      {0, static_cast<int>(2.2 * em), width, lower_top - static_cast<int>(5.8 * em)}, em);
  canvas.text(canvas.fitted(title, width - 2.0 * em, 1.1, true), 0.5 * width, height - 1.1 * em, Side::middle, 1.1, true);
  slices.draw_words(canvas);

  // Colour bar and scale bar, in one row below the slices.
  const double row_y = height - lower_top + 1.6 * em, bar_left = 0.36 * width, bar_width = 0.28 * width;
  const ColorMap& colors = slices.shades().colors;
  const double to_label = as.first.labels ? half_label : 0.0;
  std::string bar_words = as.first.words;
  if (!as.first.directions) {
    canvas.text(detail::number_words(colors.low() + to_label), bar_left - 0.6 * em, row_y, Side::right, 0.9);
    const std::string unit = shown.unit.empty() ? "  " : " " + shown.unit + ", ";
    bar_words = detail::number_words(colors.high() - to_label) + (bar_words.empty() ? "  " + label : unit + bar_words);
  }
  canvas.text(bar_words, bar_left + bar_width + 0.6 * em, row_y, Side::left, 0.9);
  const double length_m = detail::round_length(0.16 * width / slices.px_per_m());
  const double length_px = length_m * slices.px_per_m();
  canvas.rectangle(0.04 * width, row_y - 0.15 * em, length_px, 0.3 * em, {0.13, 0.13, 0.15});
  canvas.text(detail::length_words(length_m, 0.0, file_unit_m(volume)), 0.04 * width + length_px + 0.6 * em, row_y, Side::left,
              0.9);

  const bool two_parts = flow || as.second;
  const int lower_height = height - lower_top, histogram_width = two_parts ? width / 2 : width;
  if (as.second)
    canvas.text(std::string(slices.first_name()) + ", " + as.second->words, 0.75 * width, lower_height - 1.2 * em, Side::middle,
                0.9, true);

  Picture picture = window.draw();
  slices.paint(picture);
  paint_bar(picture, colors, static_cast<int>(bar_left), static_cast<int>(height - row_y - 0.45 * em), bar_width,
            static_cast<int>(0.9 * em));
  paste(picture, histogram_picture(values, label, histogram_width, lower_height), 0, lower_top);
  if (as.second) {
    slices.paint_again(picture, *as.second,
                       {histogram_width + static_cast<int>(em), lower_top + static_cast<int>(2.2 * em),
                        width - histogram_width - static_cast<int>(2.0 * em), lower_height - static_cast<int>(2.8 * em)});
  }
  if (flow)
    paste(picture, streamline_picture(volume, number, values, width - histogram_width, lower_height), histogram_width,
          lower_top);
  return picture;
}

}  // namespace palpa
