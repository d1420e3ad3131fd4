#include "palpa/baseline/law.h"

#include "palpa/baseline/ikits_2003.h"
#include "palpa/baseline/no_proxy.h"
#include "palpa/baseline/paper_2005.h"
#include "palpa/core/solver.h"

namespace palpa::baseline {

std::unique_ptr<Law> law(const Scene& scene) {
  if (scene.law == "exact") return std::make_unique<Solver>();
  if (scene.law == "paper-2005") return std::make_unique<Paper2005>();
  if (scene.law == "ikits-2003") return std::make_unique<Ikits2003>();
  if (scene.law == "ikits-2003-sequential") return std::make_unique<Ikits2003>(Ikits2003::Moves::one_after_another);
  if (scene.law == "no-proxy") return std::make_unique<NoProxy>();
  throw SceneError("law.method: there is no law '" + scene.law +
                   "'; choose exact, paper-2005, ikits-2003, ikits-2003-sequential or no-proxy");
}

}  // namespace palpa::baseline
