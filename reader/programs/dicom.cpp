// palpa-read-dicom: DICOM by vtk-dicom and GDCM, and NIfTI by vtk-dicom.
#include "../serve.h"

int main(int, char** arguments) {
  using namespace palpa::reader;
  return serve(arguments[1], {{"dicom", open_dicom}, {"nifti", open_nifti}});
}
