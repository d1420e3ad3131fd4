#include "palpa/mode/inputs.h"

#include <algorithm>

namespace palpa {

namespace {

class Resolver final : public ParameterVisitor {
 public:
  Resolver(const NumberOfField& number_of, ModeInputs& inputs) : number_of_(number_of), inputs_(inputs) {}

  void field(const ParameterInfo& info, FieldRef& ref) override {
    if (ref.name.empty()) return;
    const std::int32_t number = resolve(ref, info.felt);
    if (info.name == "field") inputs_.main_field = number;
  }
  void companion(FieldRef& of, Derivation felt) override { detail::field_numbers(of).companion = number_of(of, felt); }
  void strength(const ParameterInfo&, Strength& strength) override {
    if (strength.is_constant()) {
      constant_ = constant_ || strength.constant_n != 0.0;
      return;
    }
    inputs_.strengths.push_back(&strength);
    watch(strength.of, strength.curve);
  }
  void number(const ParameterInfo& info, double& value) override {
    if (info.kind == ParameterKind::level) {
      has_levels_ = true;
      inputs_.watches.push_back({inputs_.main_field, value});
    } else if (info.name.ends_with("_ns_per_m")) {
      constant_ = constant_ || value != 0.0;
    }
  }
  void list(const ParameterInfo&, ParameterList& list) override {
    for (std::size_t i = 0; i < list.size(); ++i) list.visit(i, *this);
  }
  void mask(Mask& mask) { watch(mask.of, mask.curve); }

  bool onset_is_watched() const noexcept { return has_levels_ || (!constant_ && !inputs_.strengths.empty()); }

 private:
  std::int32_t number_of(const FieldRef& ref, std::optional<Derivation> felt) {
    const std::int32_t number = number_of_(ref, felt);
    if (std::ranges::find(inputs_.fields, number) == inputs_.fields.end()) inputs_.fields.push_back(number);
    return number;
  }
  std::int32_t resolve(FieldRef& ref, std::optional<Derivation> felt = {}) {
    return detail::field_numbers(ref).field = number_of(ref, felt);
  }
  // A strength can set in, or jump, only at its points.
  void watch(FieldRef& ref, const TransferFunction& curve) {
    const std::int32_t number = resolve(ref);
    for (const TransferFunction::Point& point : curve.points()) inputs_.watches.push_back({number, point.value});
  }

  const NumberOfField& number_of_;
  ModeInputs& inputs_;
  bool has_levels_ = false;
  bool constant_ = false;
};

}  // namespace

ModeInputs resolve(Mode& mode, std::span<Mask> masks, const NumberOfField& number_of) {
  ModeInputs inputs;
  Resolver resolver(number_of, inputs);
  mode.visit(resolver);
  for (Mask& mask : masks) resolver.mask(mask);
  inputs.onset_is_watched = resolver.onset_is_watched();
  return inputs;
}

}  // namespace palpa
