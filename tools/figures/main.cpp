// Draws the figures of docs/pictures that no scene gives: those of the paper, of docs/theory.md and of docs/path.md.
//   palpa_draw_figures FOLDER
#include <cstdio>
#include <exception>
#include <filesystem>
#include <utility>
#include <vector>

#include "tools/figures/paper_figures.h"
#include "tools/figures/path_figures.h"
#include "tools/figures/theory_figures.h"

int main(int count, char** arguments) {
  if (count != 2) {
    std::fprintf(stderr, "usage: palpa_draw_figures FOLDER\n");
    return 2;
  }
  try {
    std::vector<palpa::Figure> figures = palpa::paper_figures();
    figures.push_back(palpa::laws_figure(PALPA_SCENES_FOLDER));
    for (palpa::Figure& figure : palpa::theory_figures()) figures.push_back(std::move(figure));
    for (palpa::Figure& figure : palpa::path_figures()) figures.push_back(std::move(figure));
    for (const std::filesystem::path& file : palpa::write_figures(arguments[1], figures)) std::printf("%s\n", file.c_str());
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "palpa_draw_figures: %s\n", error.what());
    return 2;
  }
}
