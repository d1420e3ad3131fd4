// palpa-read-vtk: VTK's own formats.
#include "../serve.h"

int main(int, char** arguments) {
  using namespace palpa::reader;
  return serve(arguments[1], {{"legacy", open_legacy_vtk}, {"xml", open_vtk_xml}});
}
