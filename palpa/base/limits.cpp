#include "palpa/base/limits.h"

#include "palpa/base/printed.h"

namespace palpa {

namespace {

constexpr Limit table[] = {
#define PALPA_LIMIT(name, most, unit, of_what, protects, remedy) limit::name,
#include "palpa/base/limits.def"
#undef PALPA_LIMIT
};

}  // namespace

std::string quantity(const Limit& limit) {
  constexpr double mebibyte = 1 << 20;
  if (limit.unit == "bytes" && limit.most >= mebibyte) return detail::text("%g MiB", limit.most / mebibyte);
  return detail::text("%.0f ", limit.most) + std::string(limit.unit);
}

std::string more_than(const Limit& limit) { return "more than " + quantity(limit) + "; " + std::string(limit.remedy); }

std::string limits_reference_markdown() {
  std::string out = "| of what | at most | what it protects | what would be right |\n|---|---|---|---|\n";
  for (const Limit& limit : table) {
    const std::string most = quantity(limit);
    const std::size_t space = most.find(' ');
    out += "| " + std::string(limit.of_what) + " | " + detail::grouped(most.substr(0, space)) + most.substr(space) + " | " +
           std::string(limit.protects) + " | " + std::string(limit.remedy) + " |\n";
  }
  return out;
}

std::span<const Limit> all_limits() noexcept { return table; }

}  // namespace palpa
