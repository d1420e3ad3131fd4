// palpa-read-cfd: PLOT3D and OpenFOAM by VTK's readers, which bring more libraries than its own formats need.
#include "../serve.h"

int main(int, char** arguments) {
  using namespace palpa::reader;
  return serve(arguments[1], {{"plot3d", open_plot3d}, {"openfoam", open_openfoam}});
}
