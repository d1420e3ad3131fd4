// Draws the figures of docs/pictures that no scene gives: those of the paper, of docs/theory.md and of docs/path.md.
//   palpa_draw_figures FOLDER [NAME]      all, or the one of that name
#include <cstdio>
#include <exception>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "tools/figures/paper_figures.h"
#include "tools/figures/path_figures.h"
#include "tools/figures/theory_figures.h"

int main(int count, char** arguments) {
  if (count != 2 && count != 3) {
    std::fprintf(stderr, "usage: palpa_draw_figures FOLDER [NAME]\n");
    return 2;
  }
  const std::string name = count == 3 ? arguments[2] : "";
  const auto wanted = [&name](const char* beginning) { return name.empty() || name.starts_with(beginning); };
  try {
    std::vector<palpa::Figure> figures;
    const auto add = [&figures](std::vector<palpa::Figure> more) {
      for (palpa::Figure& figure : more) figures.push_back(std::move(figure));
    };
    if (wanted("fig")) add(palpa::paper_figures());
    if (wanted("fig6")) figures.push_back(palpa::laws_figure(PALPA_SCENES_FOLDER));
    if (wanted("theory")) add(palpa::theory_figures());
    if (wanted("path")) add(palpa::path_figures());
    if (!name.empty()) std::erase_if(figures, [&name](const palpa::Figure& figure) { return figure.name != name; });
    if (figures.empty()) {
      std::fprintf(stderr, "palpa_draw_figures: %s: no figure has this name\n", name.c_str());
      return 2;
    }
    for (const std::filesystem::path& file : palpa::write_figures(arguments[1], figures)) std::printf("%s\n", file.c_str());
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "palpa_draw_figures: %s\n", error.what());
    return 2;
  }
}
