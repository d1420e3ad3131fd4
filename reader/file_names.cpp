#include "file_names.h"

#include <cctype>
#include <string>

namespace palpa::reader {

namespace fs = std::filesystem;

namespace {

std::string lower(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

/// Path with the last `from` in its file name replaced by `to`, in equal letter case; empty if the name has none.
fs::path renamed(const fs::path& path, const std::string& from, const std::string& to) {
  const std::string name = path.filename().string();
  const std::size_t at = lower(name).rfind(from);
  if (at == std::string::npos) return {};
  std::string other = to;
  if (std::isupper(static_cast<unsigned char>(name[at])) != 0) {
    for (char& c : other) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  }
  return path.parent_path() / (name.substr(0, at) + other + name.substr(at + from.size()));
}

}  // namespace

Plot3dPart plot3d_part(const fs::path& path) {
  const std::string name = lower(path.filename().string()), stem = lower(path.stem().string());
  const std::string extension = lower(path.extension().string());
  const auto ends = [](const std::string& text, const std::string& end) {
    return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
  };
  if (extension == ".xyz" || extension == ".x" || extension == ".p3dxyz") return Plot3dPart::grid;
  if (extension == ".q" || extension == ".p3dq") return Plot3dPart::solution;
  if (extension != ".bin" && extension != ".p3d" && extension != ".dat" && extension != ".fmt") return Plot3dPart::unknown;
  if (ends(stem, "xyz")) return Plot3dPart::grid;
  return ends(stem, "q") ? Plot3dPart::solution : Plot3dPart::unknown;
}

fs::path plot3d_partner(const fs::path& path) {
  const bool is_grid = plot3d_part(path) == Plot3dPart::grid;
  static constexpr const char* pairs[][2] = {{"xyz", "q"}, {".xyz", ".q"}, {".x", ".q"}, {"p3dxyz", "p3dq"}};
  for (const auto& [grid, solution] : pairs) {
    const fs::path other = is_grid ? renamed(path, grid, solution) : renamed(path, solution, grid);
    std::error_code ignored;
    if (!other.empty() && other != path && fs::is_regular_file(other, ignored)) return other;
  }
  return {};
}

fs::path openfoam_case(const fs::path& path) {
  std::error_code ignored;
  fs::path folder = path;
  if (!fs::is_directory(path, ignored)) {
    folder = path.parent_path().empty() ? fs::path(".") : path.parent_path();
    if (path.filename() == "controlDict")
      folder = folder / "..";
    else if (path.extension() != ".foam")
      return {};
  }
  return fs::is_regular_file(folder / "system" / "controlDict", ignored) ? folder : fs::path();
}

}  // namespace palpa::reader
