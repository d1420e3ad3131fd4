#include "app/info_place.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <vector>

#include "app/info_numbers.h"
#include "palpa/data/length_unit.h"

namespace palpa::app {
namespace {

double metres_of(const std::string& unit) {
  const auto known = detail::length_unit(unit);
  return known ? known->metres : 0.0;
}

[[noreturn]] void refuse(const std::string& text) {
  throw LoadError(
      "--at " + text +
      ": is no place; write a voxel as 120,200,90, a position as -5mm,16mm,7mm, or one of the patient as R5,A16,S7");
}

/// One of the three parts of a place: `R5.0mm`.
struct Part {
  char letter = ' ';
  double number = 0.0;
  std::string unit;
};

std::vector<Part> parts_of(const std::string& text) {
  std::vector<Part> parts;
  for (std::size_t from = 0; from <= text.size();) {
    const std::size_t to = std::min(text.find(',', from), text.size());
    std::string word = text.substr(from, to - from);
    word.erase(std::remove(word.begin(), word.end(), ' '), word.end());
    Part part;
    if (!word.empty() && std::isalpha(static_cast<unsigned char>(word.front()))) {
      part.letter = static_cast<char>(std::toupper(static_cast<unsigned char>(word.front())));
      word.erase(0, 1);
    }
    const auto read = std::from_chars(word.data(), word.data() + word.size(), part.number);
    if (read.ec != std::errc{} || !std::isfinite(part.number)) refuse(text);
    part.unit = word.substr(static_cast<std::size_t>(read.ptr - word.data()));
    if (!part.unit.empty() && metres_of(part.unit) == 0.0) refuse(text);
    parts.push_back(std::move(part));
    from = to + 1;
  }
  if (parts.size() != 3) refuse(text);
  // A unit behind the last number applies to all three.
  for (Part& part : parts) {
    if (part.unit.empty()) part.unit = parts.back().unit;
    if (part.unit.empty() != parts.back().unit.empty()) refuse(text);
  }
  return parts;
}

/// "R 5.0": millimetres and the letter of the side. \param positive  letter for m >= 0
std::string side_words(double m, char positive, char negative) {
  const double mm = 1e3 * std::abs(m);
  return fmt::format("{} {}", m < 0.0 ? negative : positive, mm < 1000.0 ? fmt::format("{:.1f}", mm) : rounded_words(mm));
}

double distance_from(const Box& box, const Vec3& at) {
  const auto beyond = [](double low, double high, double x) { return std::max({low - x, x - high, 0.0}); };
  return norm(Vec3{beyond(box.low_m.x, box.high_m.x, at.x), beyond(box.low_m.y, box.high_m.y, at.y),
                   beyond(box.low_m.z, box.high_m.z, at.z)});
}

}  // namespace

AskedPlace asked_place(const std::string& text) {
  const std::vector<Part> parts = parts_of(text);
  const auto in_metres = [](const Part& part, const char* otherwise) {
    return part.number * metres_of(part.unit.empty() ? otherwise : part.unit);
  };
  if (std::all_of(parts.begin(), parts.end(), [](const Part& part) { return part.letter == ' '; })) {
    if (parts.back().unit.empty()) return {AskedPlace::In::grid, {parts[0].number, parts[1].number, parts[2].number}, text};
    return {AskedPlace::In::world, {in_metres(parts[0], "m"), in_metres(parts[1], "m"), in_metres(parts[2], "m")}, text};
  }
  AskedPlace place{AskedPlace::In::patient, {}, text};
  std::string axes;
  for (const Part& part : parts) {
    static constexpr std::string_view letters = "LRPASI";
    const std::size_t letter = letters.find(part.letter);
    if (part.letter == ' ' || letter == std::string_view::npos) refuse(text);
    double* const axis[] = {&place.at.x, &place.at.y, &place.at.z};
    *axis[letter / 2] = (letter % 2 == 0 ? 1.0 : -1.0) * in_metres(part, "mm");
    axes += "xyz"[letter / 2];
  }
  std::sort(axes.begin(), axes.end());
  if (axes != "xyz") refuse(text);
  return place;
}

AskedPlace asked_place_m(const std::string& text) {
  Vec3 position_m;
  const char* next = text.data();
  const char* const end = next + text.size();
  for (double* number : {&position_m.x, &position_m.y, &position_m.z}) {
    const auto read = std::from_chars(next, end, *number);
    const bool last = number == &position_m.z;
    if (read.ec != std::errc{} || (last ? read.ptr != end : read.ptr == end || *read.ptr != ',')) {
      throw LoadError("--at-m " + text + ": is no position; write X,Y,Z in metres of the world, as in 0.01,-0.05,0");
    }
    next = read.ptr + 1;
  }
  if (!is_finite(position_m)) throw LoadError("--at-m " + text + ": is not finite; write three numbers");
  return {AskedPlace::In::world, position_m, text};
}

Vec3 world_of(const AskedPlace& place, const Facts& facts) {
  if (place.in == AskedPlace::In::grid) return facts.placed.grid.to_world({place.at.x, place.at.y, place.at.z});
  if (place.in == AskedPlace::In::patient && !facts.file.volume.medical_frame) {
    throw LoadError("--at " + place.text + ": " + facts.name +
                    " does not say how a patient lies in it; write a voxel as 120,200,90 or a position as -5mm,16mm,7mm");
  }
  return place.at;
}

GridPoint voxel_of(const Facts& facts, const Vec3& world_m) {
  const GridGeometry& grid = facts.placed.grid;
  const Vec3 steps = inverse(grid.index_to_world_m) * (world_m - grid.origin_m);
  const auto among = [&](std::size_t axis, double step) {
    const std::vector<double>& planes = grid.planes[axis];
    if (planes.size() < 2) return step;
    const auto above = std::clamp<std::ptrdiff_t>(std::upper_bound(planes.begin(), planes.end(), step) - planes.begin(), 1,
                                                  static_cast<std::ptrdiff_t>(planes.size()) - 1);
    const auto n = static_cast<std::size_t>(above);
    return static_cast<double>(n - 1) + (step - planes[n - 1]) / (planes[n] - planes[n - 1]);
  };
  return {among(0, steps.x), among(1, steps.y), among(2, steps.z)};
}

std::string format_place(const Facts& facts, const Vec3& world_m) {
  if (!facts.file.volume.medical_frame) return in_one_unit(facts, world_m);
  return side_words(world_m.x, 'L', 'R') + ", " + side_words(world_m.y, 'P', 'A') + ", " + side_words(world_m.z, 'S', 'I') +
         " mm";
}

std::string format_place(const Facts& facts, const Box& box_m) {
  if (!facts.file.volume.medical_frame) return in_one_unit(facts, box_m.low_m) + " to " + in_one_unit(facts, box_m.high_m);
  const auto range = [](double low_m, double high_m, char positive, char negative) {
    return side_words(low_m, positive, negative) + " to " + side_words(high_m, positive, negative);
  };
  return range(box_m.low_m.x, box_m.high_m.x, 'L', 'R') + ", " + range(box_m.low_m.y, box_m.high_m.y, 'P', 'A') + ", " +
         range(box_m.low_m.z, box_m.high_m.z, 'S', 'I') + " mm";
}

std::string why_outside(const AskedPlace& place, const Facts& facts, const Vec3& world_m) {
  const Box box = facts.file.volume.bounds_m();
  const double away_m = distance_from(box, world_m), longest_m = largest_component(box.size_m());
  std::string words = "outside of the data";
  if (away_m > 0.0) words += ", " + length_words(away_m) + " away";
  if (place.in == AskedPlace::In::world && away_m > 20.0 * longest_m) {
    const auto& n = facts.placed.grid.dims;
    words += fmt::format(": metres? The data are {} long; --at {} takes a voxel (of {} x {} x {}), --at {}mm millimetres",
                         length_words(longest_m), place.text, n[0], n[1], n[2], place.text);
  }
  return words;
}

}  // namespace palpa::app
