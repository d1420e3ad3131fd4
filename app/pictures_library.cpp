// palpa-pictures.so (pictures.h).
#include "app/pictures.h"
#include "app/scenes_folder.h"
#include "palpa/core/load_error.h"
#include "palpa/report/figures.h"
#include "palpa/report/path_figures.h"
#include "palpa/report/theory_figures.h"
#include "palpa/version.h"
#include "palpa/view/volume_picture.h"
#include "palpa/volume/volume.h"

namespace palpa::app {
namespace {

std::vector<std::filesystem::path> draw_figures(const std::filesystem::path& folder, std::vector<std::string>& warnings) {
  std::vector<Figure> figures = paper_figures();
  try {
    figures.push_back(laws_figure(scenes_folder()));
  } catch (const LoadError& error) {
    warnings.push_back(std::string("the figure of the laws is left out: ") + error.what());
  }
  for (Figure& figure : theory_figures()) figures.push_back(std::move(figure));
  for (Figure& figure : path_figures()) figures.push_back(std::move(figure));
  return write_figures(folder, figures);
}

void draw_volume(const Volume& volume, std::size_t field, const Statistics& values, const std::string& what,
                 const std::filesystem::path& file) {
  save_png(volume_picture(volume, field, values, what), file);
}

}  // namespace

extern "C" __attribute__((visibility("default"))) const Pictures palpa_pictures;
const Pictures palpa_pictures{version, write_report, draw_figures, draw_volume};

}  // namespace palpa::app
