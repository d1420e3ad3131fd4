#include "palpa/report/html.h"

#include <cstdint>

namespace palpa::detail {
std::string table(const std::vector<std::string>& head, const std::vector<std::vector<std::string>>& rows, std::size_t left) {
  const auto cell = [&](const char* tag, std::size_t column, const std::string& content) {
    return std::string("<") + tag + (column < left ? "" : " class=\"number\"") +
           (std::string(tag) == "th" ? " scope=\"col\"" : "") + ">" + escaped(content) + "</" + tag + ">";
  };
  std::string out = "<div class=\"wide\"><table>\n";
  if (!head.empty()) {
    out += "<thead><tr>";
    for (std::size_t c = 0; c < head.size(); ++c) out += cell("th", c, head[c]);
    out += "</tr></thead>\n";
  }
  out += "<tbody>\n";
  for (const auto& row : rows) {
    out += "<tr>";
    for (std::size_t c = 0; c < row.size(); ++c) out += cell("td", c, row[c]);
    out += "</tr>\n";
  }
  return out + "</tbody></table></div>\n";
}

std::string base64(std::string_view bytes) {
  constexpr char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t bits = 0;
    for (std::size_t j = 0; j < 3; ++j)
      bits = bits << 8 | (i + j < bytes.size() ? static_cast<unsigned char>(bytes[i + j]) : 0u);
    for (std::size_t j = 0; j < 4; ++j) out += i + j <= bytes.size() ? digits[bits >> (18 - 6 * j) & 63] : '=';
  }
  return out;
}

std::string png_address(std::string_view png) { return "data:image/png;base64," + base64(png); }

}  // namespace palpa::detail
