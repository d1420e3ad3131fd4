#include "tests/report/browser.h"

#include <gtest/gtest.h>
#include <unistd.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPNGReader.h>

#include <charconv>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include "palpa/data/sha256.h"
#include "palpa/report/html.h"

namespace palpa {
namespace {

namespace fs = std::filesystem;

std::string text_of(const fs::path& file) {
  std::ostringstream text;
  text << std::ifstream(file, std::ios::binary).rdbuf();
  return text.str();
}

Screen decoded(const fs::path& png) {
  vtkNew<vtkPNGReader> reader;
  reader->SetFileName(png.c_str());
  reader->Update();
  vtkImageData& image = *reader->GetOutput();
  Screen screen;
  screen.width_px = image.GetDimensions()[0];
  screen.height_px = image.GetDimensions()[1];
  for (int y = screen.height_px - 1; y >= 0; --y) {
    for (int x = 0; x < screen.width_px; ++x) {
      for (int c = 0; c < 3; ++c) screen.rgb.push_back(static_cast<std::uint8_t>(image.GetScalarComponentAsDouble(x, y, 0, c)));
    }
  }
  return screen;
}

}  // namespace

bool has_browser() { return std::system("command -v chromium >/dev/null 2>&1") == 0; }

Shown open_page(const fs::path& page, const fs::path& folder, const std::vector<std::string>& options) {
  const fs::path png = folder / "screen.png", out = folder / "document.html", err = folder / "log.txt";
  fs::remove(png);
  std::string command =
      "timeout 200 chromium --headless=new --no-first-run --hide-scrollbars --use-gl=angle "
      "--use-angle=swiftshader --enable-unsafe-swiftshader --enable-logging=stderr --v=0 "
      "--window-size=1280,1600 --virtual-time-budget=10000 --dump-dom";
  if (::geteuid() == 0) command += " --no-sandbox";
  command += " --user-data-dir='" + (folder / "profile").string() + "' --screenshot='" + png.string() + "'";
  for (const std::string& option : options) command += " '" + option + "'";
  command += " 'file://" + page.string() + "' >'" + out.string() + "' 2>'" + err.string() + "'";
  EXPECT_EQ(std::system(command.c_str()), 0) << command << "\n" << text_of(err);
  Shown shown;
  shown.document = text_of(out);
  std::istringstream log(text_of(err));
  for (std::string line; std::getline(log, line);) {
    if (line.find(":CONSOLE") != std::string::npos) shown.console.push_back(line);
  }
  if (fs::exists(png)) shown.screen = decoded(png);
  return shown;
}

std::string with_script(const std::string& html, const std::string& script, const fs::path& folder) {
  const fs::path file = folder / "script.js";
  std::ofstream(file, std::ios::binary) << script;
  const std::string hex = detail::sha256_of_file(file.string());
  std::string bytes;
  for (std::size_t i = 0; i + 1 < hex.size(); i += 2) {
    unsigned byte = 0;
    std::from_chars(hex.data() + i, hex.data() + i + 2, byte, 16);
    bytes += static_cast<char>(byte);
  }
  std::string page = html;
  page.insert(page.find("script-src") + 10, " 'sha256-" + detail::base64(bytes) + "'");
  page.insert(page.rfind("</body>"), "<script>" + script + "</script>\n");
  return page;
}

}  // namespace palpa
