// The mode of example 03 as a plug-in: an unchanged struct, and one line in place of main().
#include <palpa/palpa.h>

struct Ridge {
  static constexpr auto type = "lab.ridge";
  static constexpr auto summary = "A one-way road: free up the field, held on the way down.";
  palpa::FieldRef field;
  palpa::Strength strength_n{1.0};
  static constexpr auto parameters() {
    return std::tuple{palpa::param("field", &Ridge::field, "scalar field to feel"),
                      palpa::param("strength_n", &Ridge::strength_n, "force that holds the hand", palpa::Range{0, 10})};
  }
  void place(const palpa::ModeContext& here, palpa::PrimitiveSink out) const noexcept {
    const auto sample = here.scalar(field);
    if (!sample.inside || norm(sample.gradient) == 0) return;
    out.plane(0, here.proxy_m, normalized(sample.gradient), here.newtons(strength_n));
  }
};

PALPA_MODES(Ridge)
