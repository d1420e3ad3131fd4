#include "palpa/baseline/law.h"

#include "palpa/baseline/ikits_2003.h"
#include "palpa/baseline/no_proxy.h"
#include "palpa/baseline/paper_2005.h"
#include "palpa/solver/solver.h"

namespace palpa::baseline {

std::unique_ptr<Law> law(std::string_view name) {
  if (name == "exact") return std::make_unique<Solver>();
  if (name == "paper-2005") return std::make_unique<Paper2005>();
  if (name == "ikits-2003") return std::make_unique<Ikits2003>();
  if (name == "ikits-2003-sequential") return std::make_unique<Ikits2003>(Ikits2003::Moves::one_after_another);
  if (name == "no-proxy") return std::make_unique<NoProxy>();
  return nullptr;
}

}  // namespace palpa::baseline
