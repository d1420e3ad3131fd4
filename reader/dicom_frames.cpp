#include "dicom_frames.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>
#include <utility>

#include "palpa/base/load_error.h"

namespace palpa::reader {
namespace {

/// [pixels] Tolerance of equal positions. Less: rounded positions of frames count as slices; more: thin slices merge.
constexpr double same_place = 0.01;

/// Most consecutive empty images. More: a wrong position takes memory; less: distant parts of a segment are interpolated.
constexpr int most_blanks = 1000;

using Members = std::vector<std::size_t>;  ///< slices of a stack, by index

/// Values of every attribute in a stack, numbered in rising order.
class Values {
 public:
  explicit Values(const std::vector<Slice>& stack)
      : of_(stack.size(), std::vector<int>(static_cast<std::size_t>(attributes()), -1)),
        counts_(static_cast<std::size_t>(attributes()), 0),
        said_(static_cast<std::size_t>(attributes())) {
    std::vector<std::vector<std::pair<const Trait*, std::size_t>>> said(counts_.size());
    for (std::size_t n = 0; n < stack.size(); ++n) {
      for (const Trait& trait : stack[n].traits) said[static_cast<std::size_t>(trait.attribute)].emplace_back(&trait, n);
    }
    for (std::size_t a = 0; a < said.size(); ++a) number(said[a], a, stack.size());
  }

  /// -1: missing in the slice.
  int of(std::size_t slice, int attribute) const { return of_[slice][static_cast<std::size_t>(attribute)]; }
  /// Number of values, counting "missing" as a value.
  int count(int attribute) const { return counts_[static_cast<std::size_t>(attribute)]; }
  /// "4.6, 9.2 ms"; empty for many values, or words, which are free text and may identify a patient.
  std::string words(int number) const {
    const auto& values = said_[static_cast<std::size_t>(number)];
    constexpr std::size_t most = 8;
    static const std::set<std::string> plain{"MAGNITUDE", "PHASE", "REAL", "IMAGINARY", "MIXED", "LABEL", "CONTROL"};
    std::string text;
    for (const Trait* trait : values) {
      const bool is_word = trait->numbers.empty();
      if (values.size() > most || trait->numbers.size() > 1 || (is_word && plain.count(trait->words) == 0)) return {};
      text += (text.empty() ? "" : ", ") + (is_word ? trait->words : text_of(trait->numbers.front()));
    }
    const std::string_view unit = attribute(number).unit;
    return text + (unit.empty() || text.empty() ? "" : " " + std::string(unit));
  }

 private:
  static bool is_one(const Trait& a, const Trait& b, double tolerance) {
    if (a.words != b.words || a.numbers.size() != b.numbers.size()) return false;
    for (std::size_t n = 0; n < a.numbers.size(); ++n) {
      const double scale = a.numbers.size() == 1 ? std::max(std::abs(a.numbers[n]), std::abs(b.numbers[n])) : 1.0;
      if (std::abs(a.numbers[n] - b.numbers[n]) > tolerance * scale) return false;
    }
    return true;
  }

  void number(std::vector<std::pair<const Trait*, std::size_t>>& said, std::size_t a, std::size_t slices) {
    const double tolerance = attribute(static_cast<int>(a)).tolerance;
    std::ranges::stable_sort(said, [](const auto& one, const auto& other) {
      return std::tie(one.first->numbers, one.first->words) < std::tie(other.first->numbers, other.first->words);
    });
    std::vector<const Trait*>& values = said_[a];
    for (const auto& [trait, slice] : said) {
      // Numbers are sorted, so only the last can be near; directions may be near to any.
      std::size_t known = values.size();
      for (std::size_t back = values.size(); back > 0 && known == values.size(); --back) {
        if (is_one(*values[back - 1], *trait, tolerance)) known = back - 1;
        if (trait->numbers.size() < 2) break;
      }
      if (known == values.size()) values.push_back(trait);
      of_[slice][a] = static_cast<int>(known);
    }
    counts_[a] = static_cast<int>(values.size()) + (said.size() < slices && !said.empty() ? 1 : 0);
  }

  std::vector<std::vector<int>> of_;
  std::vector<int> counts_;
  std::vector<std::vector<const Trait*>> said_;
};

class Sorter {
 public:
  Sorter(std::vector<Slice> stack, std::vector<std::string>& warnings)
      : stack_(std::move(stack)), values_(stack_), warnings_(warnings), place_(stack_.size(), 0) {}

  Frames sorted() {
    if (stack_.front().placed) find_places();
    for (int a = 0; a < attributes(); ++a) {
      if (attribute(a).apart != Apart::kind || values_.count(a) < 2) continue;
      (counts_images(a) ? counters_ : used_).push_back(a);
    }
    groups_ = {Members(stack_.size())};
    for (std::size_t n = 0; n < stack_.size(); ++n) groups_.front()[n] = n;
    for (const int a : used_) split(a);
    if (!stack_.front().placed) place_in_line();
    for (int a = 0; a < attributes(); ++a) {
      if (attribute(a).apart == Apart::setting && values_.count(a) > 1 && differs_at_a_place(a)) split(a), used_.push_back(a);
    }
    std::vector<Members> frames;
    for (const Members& group : groups_) {
      for (Members& frame : in_order(group)) frames.push_back(std::move(frame));
    }
    fill_blanks(frames);
    keep_whole(frames);
    for (const Members& frame : frames) warn_of_mixed(frame);
    return {slices_of(frames), frames.size() > 1 ? format_used() : std::string()};
  }

 private:
  void find_places() {
    const Slice& first = stack_.front();
    const Vec3 normal = normalized(cross(first.right, first.down));
    Members order(stack_.size());
    for (std::size_t n = 0; n < order.size(); ++n) order[n] = n, along_mm_.push_back(dot(normal, stack_[n].position_mm));
    std::ranges::stable_sort(order, {}, [&](std::size_t n) { return along_mm_[n]; });
    const double tolerance_mm = same_place * std::min(first.spacing_mm[0], first.spacing_mm[1]);
    double at_mm = along_mm_[order.front()];
    places_ = 1;
    for (const std::size_t n : order) {
      if (along_mm_[n] - at_mm > tolerance_mm) ++places_, at_mm = along_mm_[n];
      place_[n] = places_ - 1;
    }
  }

  /// Places images without positions in a row, separately for each kind, in the order of their numbers.
  void place_in_line() {
    const Slice& first = stack_.front();
    const double step_mm = first.thickness_mm > 0 ? first.thickness_mm : first.spacing_mm[0];
    for (Members& group : groups_) {
      std::ranges::stable_sort(group, {}, [&](std::size_t n) { return std::pair(stack_[n].number, stack_[n].frame); });
      for (std::size_t i = 0; i < group.size(); ++i) {
        place_[group[i]] = static_cast<int>(i);
        stack_[group[i]].position_mm = {0, 0, static_cast<double>(i) * step_mm};
      }
      places_ = std::max(places_, static_cast<int>(group.size()));
    }
    warnings_.push_back("says no positions of its slices: in the order of their numbers, " + text_of(step_mm) + " mm apart");
  }

  /// True if an attribute has a value per image or per position, as a counter has.
  bool counts_images(int a) const {
    if (!attribute(a).may_count) return false;
    if (values_.count(a) == static_cast<int>(stack_.size())) return true;
    std::map<int, int> place_of;
    std::set<std::pair<int, int>> pairs;
    for (std::size_t n = 0; n < stack_.size(); ++n) pairs.emplace(values_.of(n, a), place_[n]);
    return static_cast<int>(pairs.size()) == places_ && values_.count(a) == places_;
  }

  void split(int a) {
    std::vector<Members> parts;
    for (const Members& group : groups_) {
      std::map<int, Members> by_value;
      for (const std::size_t n : group) by_value[values_.of(n, a)].push_back(n);
      for (auto& [value, part] : by_value) parts.push_back(std::move(part));
    }
    groups_ = std::move(parts);
  }

  std::vector<Members> at_places(const Members& group) const {
    std::map<int, Members> there;
    for (const std::size_t n : group) there[place_[n]].push_back(n);
    std::vector<Members> places;
    for (auto& [place, members] : there) places.push_back(std::move(members));
    return places;
  }

  bool differs_at_a_place(int a) const {
    for (const Members& group : groups_) {
      for (const Members& place : at_places(group)) {
        if (std::ranges::any_of(place, [&](std::size_t n) { return values_.of(n, a) != values_.of(place.front(), a); }))
          return true;
      }
    }
    return false;
  }

  /// Frames of a group whose images differ in no kind.
  std::vector<Members> in_order(const Members& group) {
    std::vector<Members> places = at_places(group);
    std::size_t least = places.front().size(), most = least;
    for (const Members& place : places) least = std::min(least, place.size()), most = std::max(most, place.size());
    if (most == 1) return {group};
    if (least != most && least > 1) {
      throw LoadError("has " + std::to_string(least) + " to " + std::to_string(most) +
                      " images at one place: some are missing; get the whole series");
    }
    if (least != most) {
      order(places, {number_attribute("acquisition number"), number_attribute("instance number")});
      warnings_.push_back(
          "has up to " + std::to_string(most) +
          " images at one place, but not at each, which differ in no more than their times: the first of each is "
          "read");
    } else if (!by_moments(places) && !by_rest(places) && !by_numbers(places)) {
      throw LoadError("has " + std::to_string(most) +
                      " images at each place, which no attribute distinguishes; give those of one kind, in "
                      "a folder of their own");
    }
    std::vector<Members> frames(least);
    for (const Members& place : places) {
      for (std::size_t f = 0; f < least; ++f) frames[f].push_back(place[f]);
    }
    return frames;
  }

  static int number_attribute(std::string_view name) {
    int a = 0;
    while (attribute(a).name != name) ++a;
    return a;
  }

  std::vector<int> key(std::size_t n, const std::vector<int>& by) const {
    std::vector<int> values;
    for (const int a : by) values.push_back(values_.of(n, a));
    return values;
  }
  void order(std::vector<Members>& places, const std::vector<int>& by) const {
    for (Members& place : places) {
      std::ranges::stable_sort(place, {}, [&](std::size_t n) { return std::pair(key(n, by), stack_[n].frame); });
    }
  }
  /// Orders the images at each position by attributes; false if two have equal values.
  bool ordered(std::vector<Members>& places, const std::vector<int>& by) const {
    order(places, by);
    return std::ranges::all_of(places, [&](const Members& place) {
      return std::ranges::adjacent_find(place, {}, [&](std::size_t n) { return key(n, by); }) == place.end();
    });
  }

  bool by_moments(std::vector<Members>& places) {
    std::vector<int> by = counters_;
    for (int a = 0; a < attributes(); ++a) {
      if (attribute(a).apart == Apart::moment && values_.count(a) > 1) by.push_back(a);
    }
    if (by.empty() || !ordered(places, by)) return false;
    used_too_.insert(by.begin(), by.end());
    return true;
  }

  /// Orders by an element outside of the attributes that has equal values at all positions.
  bool by_rest(std::vector<Members>& places) {
    if (stack_[places.front().front()].rest.empty()) return false;
    for (std::size_t e = 0; e < stack_[places.front().front()].rest.size(); ++e) {
      const auto said = [&](std::size_t n) { return e < stack_[n].rest.size() ? stack_[n].rest[e] : std::string(); };
      const auto values = [&](const Members& place) {
        std::set<std::string> all;
        for (const std::size_t n : place) all.insert(said(n));
        return all;
      };
      const std::set<std::string> first = values(places.front());
      const auto alike = [&](const Members& place) { return values(place) == first && first.size() == place.size(); };
      if (!std::ranges::all_of(places, alike)) continue;
      for (Members& place : places) std::ranges::stable_sort(place, {}, said);
      constexpr std::size_t tag = 11;  // "(0018,9076)"
      element_ = said(places.front().front()).substr(0, tag);
      return true;
    }
    return false;
  }

  /// Groups by a clock or counter that increases frame after frame, with equal order of positions in each. A counter that
  /// increases position after position is rejected: it may count images of several kinds, in a varying order.
  bool by_numbers(std::vector<Members>& places) {
    for (int a = 0; a < attributes(); ++a) {
      if (attribute(a).apart != Apart::number || values_.count(a) < 2 || !ordered(places, {a})) continue;
      if (frame_after_frame(places, [&](std::size_t n) { return values_.of(n, a); })) return used_too_.insert(a), true;
    }
    if (std::ranges::any_of(stack_, [&](const Slice& s) { return s.file != stack_.front().file; })) return false;
    order(places, {});
    return frame_after_frame(places, [&](std::size_t n) { return stack_[n].frame; });
  }
  template <class At>
  static bool frame_after_frame(const std::vector<Members>& places, const At& at) {
    for (std::size_t f = 1; f < places.front().size(); ++f) {
      auto last = at(places.front()[f - 1]), first = at(places.front()[f]);
      for (const Members& place : places) last = std::max(last, at(place[f - 1])), first = std::min(first, at(place[f]));
      if (!(last < first)) return false;
    }
    std::vector<std::size_t> of_first;
    for (std::size_t f = 0; f < places.front().size(); ++f) {
      std::vector<std::size_t> order(places.size());
      std::iota(order.begin(), order.end(), std::size_t{0});
      std::ranges::stable_sort(order, {}, [&](std::size_t p) { return at(places[p][f]); });
      if (f == 0) of_first = order;
      if (order != of_first) return false;
    }
    return true;
  }

  /// Inserts the empty images that a segmentation omits, at each position of another segment and in the gaps.
  void fill_blanks(std::vector<Members>& frames) {
    if (!stack_.front().sparse || !stack_.front().placed) return;
    std::map<int, Vec3> position_mm;
    for (std::size_t n = 0; n < place_.size(); ++n) position_mm[place_[n] *= most_blanks] = stack_[n].position_mm;
    fill_gaps(position_mm);
    for (Members& frame : frames) {
      std::set<int> there;
      for (const std::size_t n : frame) there.insert(place_[n]);
      for (const auto& [place, at_mm] : position_mm) {
        if (there.count(place) > 0) continue;
        Slice blank = stack_[frame.front()];
        blank.blank = true, blank.position_mm = at_mm;
        frame.push_back(stack_.size());
        stack_.push_back(std::move(blank)), place_.push_back(place);
      }
    }
  }

  /// Adds the positions of images that no segment has, if each gap is a whole number of slice distances.
  void fill_gaps(std::map<int, Vec3>& position_mm) const {
    const double step_mm = stack_.front().thickness_mm;
    std::map<int, Vec3> added;
    for (auto next = position_mm.begin(), here = next++; next != position_mm.end(); here = next++) {
      const Vec3 gap_mm = next->second - here->second;
      const double slices = step_mm > 0 ? norm(gap_mm) / step_mm : 1.0;
      if (std::abs(slices - std::round(slices)) > 0.1 || slices > most_blanks) return;
      const int count = static_cast<int>(std::round(slices));
      for (int i = 1; i < count; ++i) added[here->first + i] = here->second + gap_mm * (static_cast<double>(i) / count);
    }
    position_mm.merge(added);
  }

  /// Keeps the frames at the positions of the largest frame.
  void keep_whole(std::vector<Members>& frames) {
    const auto places = [&](const Members& frame) {
      std::set<int> all;
      for (const std::size_t n : frame) all.insert(place_[n]);
      return all;
    };
    const std::set<int> whole = places(*std::ranges::max_element(frames, {}, &Members::size));
    std::size_t lost = 0;
    for (const Members& frame : frames) lost += places(frame) != whole ? frame.size() : 0;
    if (lost == 0) return;
    warnings_.push_back("has images that differ in " + format_used() +
                        " and are not at the same places: " + std::to_string(lost) + " of " + std::to_string(stack_.size()) +
                        " are left out; give those of one kind in a folder of their own");
    std::erase_if(frames, [&](const Members& frame) { return places(frame) != whole; });
  }

  void warn_of_mixed(const Members& frame) {
    for (int a = 0; a < attributes(); ++a) {
      if (!attribute(a).named_if_mixed || values_.count(a) < 2 || !named_.insert(a).second) continue;
      const auto differs = [&](std::size_t n) { return !stack_[n].blank && values_.of(n, a) != values_.of(frame.front(), a); };
      if (std::ranges::any_of(frame, differs)) {
        const std::string values = values_.words(a);
        warnings_.push_back("has slices that differ in " + std::string(attribute(a).name) +
                            (values.empty() ? "" : " (" + values + ")") + " in one volume");
      } else {
        named_.erase(a);
      }
    }
  }

  std::string format_used() const {
    std::vector<int> all = used_;
    all.insert(all.end(), used_too_.begin(), used_too_.end());
    std::string text;
    for (std::size_t n = 0; n < all.size(); ++n) {
      const std::string values = values_.words(all[n]);
      text += (n == 0                ? ""
               : n + 1 == all.size() ? " and "
                                     : ", ") +
              std::string(attribute(all[n]).name) + (values.empty() ? "" : " (" + values + ")");
    }
    if (!element_.empty()) text += (text.empty() ? "element " : " and element ") + element_;
    return text.empty() ? "their order" : text;
  }

  std::vector<std::vector<Slice>> slices_of(std::vector<Members>& frames) {
    std::vector<std::vector<Slice>> slices;
    for (Members& frame : frames) {
      std::ranges::sort(frame, {}, [&](std::size_t n) { return place_[n]; });
      slices.emplace_back();
      for (const std::size_t n : frame) slices.back().push_back(stack_[n]);
    }
    return slices;
  }

  std::vector<Slice> stack_;
  const Values values_;
  std::vector<std::string>& warnings_;
  std::vector<int> place_;  ///< of each slice, rising along the normal
  int places_ = 0;
  std::vector<double> along_mm_;
  std::vector<Members> groups_;
  std::vector<int> used_;      ///< attributes that distinguish the groups
  std::set<int> used_too_;     ///< moments and numbers that distinguish frames of a group
  std::vector<int> counters_;  ///< kinds in which a program has counted the images
  std::string element_;        ///< another element that distinguishes frames
  std::set<int> named_;
};

}  // namespace

Frames frames_of(std::vector<Slice> stack, std::vector<std::string>& warnings) {
  return Sorter(std::move(stack), warnings).sorted();
}

}  // namespace palpa::reader
