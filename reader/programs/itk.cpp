// palpa-read-itk: NRRD and MetaImage by ITK's libraries.
#include "../serve.h"

int main(int, char** arguments) {
  using namespace palpa::reader;
  return serve(arguments[1], {{"nrrd", open_nrrd}, {"metaimage", open_metaimage}});
}
