// A page in a browser without a window: what it shows, what it logs, what it has become.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace palpa {

/// Of a screenshot, rows from top to bottom.
struct Screen {
  int width_px = 0;
  int height_px = 0;
  std::vector<std::uint8_t> rgb;
  const std::uint8_t* at(int x_px, int y_px) const { return &rgb[3 * (static_cast<std::size_t>(y_px) * width_px + x_px)]; }
};

struct Shown {
  Screen screen;
  std::string document;              ///< the page as it was in the end
  std::vector<std::string> console;  ///< what it logged, errors among it
};

/// Whether Chromium is there.
bool has_browser();

/// Opens `page` in Chromium, with `options` beside those that a machine without screen and graphics card wants, lets it run for
/// some seconds of its own time, and looks. `folder` takes its files.
Shown open_page(const std::filesystem::path& page, const std::filesystem::path& folder,
                const std::vector<std::string>& options = {});

/// The page with one more script, which its Content-Security-Policy is told to run.
std::string with_script(const std::string& html, const std::string& script, const std::filesystem::path& folder);

}  // namespace palpa
