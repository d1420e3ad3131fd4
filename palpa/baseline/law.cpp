#include "palpa/baseline/law.h"

#include <algorithm>
#include <array>

#include "palpa/baseline/ikits_2003.h"
#include "palpa/baseline/no_proxy.h"
#include "palpa/baseline/paper_2005.h"
#include "palpa/solver/solver.h"

namespace palpa::baseline {
namespace {

struct NamedLaw {
  const char* name;
  std::unique_ptr<Law> (*make)();
};

template <class L>
std::unique_ptr<Law> made() {
  return std::make_unique<L>();
}

constexpr std::array<NamedLaw, 5> laws{
    {{"exact", made<Solver>},
     {"paper-2005", made<Paper2005>},
     {"ikits-2003", made<Ikits2003>},
     {"ikits-2003-sequential",
      []() -> std::unique_ptr<Law> { return std::make_unique<Ikits2003>(Ikits2003::Moves::one_after_another); }},
     {"no-proxy", made<NoProxy>}}};

}  // namespace

std::vector<std::string> law_names() {
  std::vector<std::string> names;
  for (const NamedLaw& law : laws) names.emplace_back(law.name);
  return names;
}

std::unique_ptr<Law> law(const Scene& scene) {
  const auto found = std::ranges::find(laws, scene.law, &NamedLaw::name);
  if (found != laws.end()) return found->make();
  std::string choices;
  for (const NamedLaw& law : laws)
    choices += (choices.empty() ? "" : &law == &laws.back() ? " or " : ", ") + std::string(law.name);
  throw SceneError("law.method: there is no law '" + scene.law + "'; choose " + choices);
}

}  // namespace palpa::baseline
