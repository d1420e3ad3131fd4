#include "palpa/scene/mode_inputs.h"

#include <algorithm>

namespace palpa {

namespace {

class Resolver final : public ParameterVisitor {
 public:
  Resolver(const Scene& scene, std::vector<FieldPtr>& all, ModeInputs& inputs) : scene_(scene), all_(all), inputs_(inputs) {}

  void field(const ParameterInfo& info, FieldRef& ref) override {
    if (ref.name.empty()) return;
    resolve(ref, info.felt);
    if (info.name == "field") inputs_.main_field = ref.index;
  }
  void companion(FieldRef& ref, const FieldRef& of, Derivation felt) override {
    ref.name = of.name;
    resolve(ref, felt);
  }
  void strength(const ParameterInfo&, Strength& strength) override {
    if (strength.is_constant()) {
      constant_ = constant_ || strength.constant_n != 0.0;
      return;
    }
    inputs_.strengths.push_back(&strength);
    resolve(strength.of);
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
  void mask(Mask& mask) {
    resolve(mask.of);
    watch(mask.of, mask.curve);
  }

  bool onset_is_watched() const noexcept { return has_levels_ || (!constant_ && !inputs_.strengths.empty()); }

 private:
  void resolve(FieldRef& ref, std::optional<Derivation> felt = {}) {
    ref.index = felt ? -1 : scene_.index_of(ref);
    if (ref.index < 0) {
      const FieldPtr field = felt ? scene_.field(ref, *felt) : scene_.field(ref).field;
      const auto found = std::find(all_.begin(), all_.end(), field);
      ref.index = static_cast<std::int32_t>(found - all_.begin());
      if (found == all_.end()) all_.push_back(field);
    }
    if (std::find(inputs_.fields.begin(), inputs_.fields.end(), ref.index) == inputs_.fields.end())
      inputs_.fields.push_back(ref.index);
  }
  // A strength can set in, or jump, only at its points.
  void watch(const FieldRef& ref, const TransferFunction& curve) {
    for (const TransferFunction::Point& point : curve.points()) inputs_.watches.push_back({ref.index, point.value});
  }

  const Scene& scene_;
  std::vector<FieldPtr>& all_;
  ModeInputs& inputs_;
  bool has_levels_ = false;
  bool constant_ = false;
};

}  // namespace

ModeInputs resolve(SceneMode& mode, const Scene& scene, std::vector<FieldPtr>& fields) {
  ModeInputs inputs;
  Resolver resolver(scene, fields, inputs);
  mode.mode.visit(resolver);
  for (Mask& mask : mode.masks) resolver.mask(mask);
  inputs.onset_is_watched = resolver.onset_is_watched();
  return inputs;
}

}  // namespace palpa
