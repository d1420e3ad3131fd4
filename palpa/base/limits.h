// Table of limits: maxima of files and options, with their error texts.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

namespace palpa {

struct Limit {
  std::string_view name;
  double most = 0.0;          ///< [1], or in `unit`
  std::string_view unit;      ///< counted unit: "poses", "bytes", "s"
  std::string_view of_what;   ///< subject: "a scene"
  std::string_view protects;  ///< resource at risk above the limit
  std::string_view remedy;

  /// Whether a count is too large.
  /// \param found  [1], or in `unit`
  constexpr bool is_passed_by(double found) const noexcept { return !(found <= most); }
  constexpr std::size_t count() const noexcept { return static_cast<std::size_t>(most); }
};

/// "1000 poses", "4 MiB". Allocates; any thread.
std::string quantity(const Limit& limit);
/// End of an error line: "more than 1000 poses; give fewer a second". Allocates; any thread.
std::string more_than(const Limit& limit);

/// The table as Markdown, for docs/limits.md.
std::string limits_reference_markdown();

namespace limit {

#define PALPA_LIMIT(name, most, unit, of_what, protects, remedy) \
  inline constexpr Limit name{#name, most, unit, of_what, protects, remedy};
#include "palpa/base/limits.def"
#undef PALPA_LIMIT

}  // namespace limit

/// All limits, in the order of the table. Any thread.
std::span<const Limit> all_limits() noexcept;

}  // namespace palpa
