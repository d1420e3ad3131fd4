#include "palpa/mode/mode.h"

#include <stdexcept>

#include "palpa/mode/modes.h"

namespace palpa {

bool Mode::finds_levels(Concept& model) {
  struct Finder final : ParameterVisitor {
    void number(const ParameterInfo& info, double&) override { found = found || info.kind == ParameterKind::level; }
    void list(const ParameterInfo&, ParameterList& list) override { list.visit_default(*this); }
    bool found = false;
  } finder;
  model.visit(finder);
  return finder.found;
}

void ModeCatalog::add(Mode example) {
  if (find(example.type())) throw std::invalid_argument("mode type '" + std::string(example.type()) + "' is there already");
  modes_.push_back(std::move(example));
}

const Mode* ModeCatalog::find(std::string_view type) const noexcept {
  for (const Mode& mode : modes_) {
    if (mode.type() == type) return &mode;
  }
  return nullptr;
}

const ModeCatalog& standard_modes() {
  static const ModeCatalog catalog = [] {
    ModeCatalog c;
#define MODE(type) c.add(type{});
#include "palpa/mode/modes.def"
#undef MODE
    return c;
  }();
  return catalog;
}

}  // namespace palpa
