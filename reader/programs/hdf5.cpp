// palpa-read-hdf5: HDF5 by its own library.
#include "../serve.h"

int main(int, char** arguments) {
  using namespace palpa::reader;
  return serve(arguments[1], {{"hdf5", open_hdf5}});
}
