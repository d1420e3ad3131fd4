#include "palpa/data/ct.h"

#include <initializer_list>

namespace palpa {
namespace {

// [HU] Radiologists' level and width. Wider: less contrast; narrower: more values are plain black or white.
constexpr CtWindow brain{"brain", 40, 80}, soft_tissue{"soft tissue", 40, 400}, bone{"bone", 400, 1800},
    lung{"lung", -600, 1500};

bool says_any(std::string_view text, std::initializer_list<std::string_view> any_of) {
  for (const std::string_view word : any_of) {
    if (text.find(word) != std::string_view::npos) return true;
  }
  return false;
}

}  // namespace

std::optional<double> ct_water(const Statistics& values, const std::string& unit, const std::string& modality) {
  if (looks_like_hounsfield(values, unit, modality)) return 0.0;
  if (!modality.empty() && modality != "CT") return std::nullopt;
  const Histogram& h = values.histogram;
  const double air = h.share_between(0, 250), between = h.share_between(400, 850), tissue = h.share_between(950, 1150);
  const bool without_offset = unit.empty() && values.whole_numbers && values.min >= -100.0 && values.max > 1500.0 &&
                              values.max < 5000.0 && air > 0.05 && tissue > 0.05 && between < 0.5 * tissue;
  return without_offset ? std::optional(1024.0) : std::nullopt;
}

CtWindow ct_window(const Statistics& values, double water, std::string_view body_part, double widest_m) {
  // Shares of the values denser than air, in HU.
  const auto count = [&](double from, double to) { return values.histogram.share_between(from + water, to + water); };
  const double dense = count(-850, 1e9);
  const auto share = [&](double from, double to) { return dense > 0.0 ? count(from, to) / dense : 0.0; };
  const auto seen = [&](const CtWindow& w) { return share(w.level - 0.5 * w.width, w.level + 0.5 * w.width); };
  // [1] Share in a window above which the file's part of the body decides. Less: a wrong name gives a black picture; more:
  // right names are ignored.
  constexpr double enough = 0.15;
  if (says_any(body_part, {"brain", "head"}) && seen(brain) > enough) return brain;
  if (says_any(body_part, {"chest", "lung", "thorax"}) && seen(lung) > enough) return lung;
  if (says_any(body_part, {"abdomen", "pelvis", "liver", "neck", "heart", "cardiac"}) && seen(soft_tissue) > enough)
    return soft_tissue;
  if (says_any(body_part,
               {"spine", "skull", "knee", "hip", "foot", "ankle", "hand", "wrist", "elbow", "shoulder", "extremity"}))
    return bone;

  const double soft = share(-200, 250), fat = share(-130, -60);
  // Brain is darker than muscle, with little fat about it.
  if (body_part.empty() && widest_m < 0.32 && share(15, 50) > share(50, 100) && fat < 0.15 * soft && seen(brain) > enough)
    return brain;
  if (body_part.empty() && share(-850, -500) > 0.3) return lung;
  return soft > 0.5 ? soft_tissue : bone;
}

}  // namespace palpa
