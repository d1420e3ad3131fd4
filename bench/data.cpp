// Opening data beside what the library or tool for it needs alone: a DICOM series and a compressed NRRD, both made here.
#include <palpa/palpa.h>
#include <stdlib.h>
#include <vtkDICOMCTGenerator.h>
#include <vtkDICOMReader.h>
#include <vtkDICOMWriter.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkStringArray.h>
#include <zlib.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace fs = std::filesystem;

namespace {

constexpr int repeats = 5;

/// The shortest of some runs [s]: what the work takes when nothing else is in the way.
double shortest_s(const std::function<void()>& work) {
  double shortest = 1e9;
  for (int n = 0; n < repeats; ++n) {
    const auto start = std::chrono::steady_clock::now();
    work();
    shortest = std::min(shortest, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  }
  return shortest;
}

void print(const char* what, double alone_s, double ours_s) {
  std::printf("%-44s alone %6.3f s, read_volume %6.3f s: %.2f times\n", what, alone_s, ours_s, ours_s / alone_s);
}

/// A head of sorts: smooth, with the noise of a scanner.
std::vector<std::int16_t> voxels(int n) {
  std::vector<std::int16_t> voxels;
  voxels.reserve(static_cast<std::size_t>(n) * static_cast<std::size_t>(n) * static_cast<std::size_t>(n));
  std::uint32_t random = 1;
  const auto middle = static_cast<double>(n) / 2;
  for (int k = 0; k < n; ++k) {
    for (int j = 0; j < n; ++j) {
      for (int i = 0; i < n; ++i) {
        random = random * 1664525U + 1013904223U;
        const double r = std::hypot(i - middle, j - middle, k - middle) / middle;
        voxels.push_back(static_cast<std::int16_t>((r < 0.8 ? 40 : -1000) + static_cast<int>(random >> 28)));
      }
    }
  }
  return voxels;
}

void write_dicom(const fs::path& folder, std::vector<std::int16_t>& voxels, int n) {
  vtkNew<vtkImageData> image;
  image->SetDimensions(n, n, n);
  image->SetSpacing(0.5, 0.5, 0.5);
  image->AllocateScalars(VTK_SHORT, 1);
  std::copy(voxels.begin(), voxels.end(), static_cast<std::int16_t*>(image->GetScalarPointer()));
  vtkNew<vtkDICOMCTGenerator> generator;
  vtkNew<vtkDICOMWriter> writer;
  writer->SetGenerator(generator);
  writer->SetInputData(image);
  writer->SetFilePrefix(folder.c_str());
  writer->SetFilePattern("%s/slice%04d.dcm");
  writer->Write();
}

/// The header, and the voxels in a file of their own, which gunzip can unpack, too.
void write_nrrd(const fs::path& file, const std::vector<std::int16_t>& voxels, int n) {
  const std::string size = " " + std::to_string(n);
  const std::string header = "NRRD0004\ntype: short\ndimension: 3\nsizes:" + size + size + size +
                             "\nspacings: 0.5 0.5 0.5\nencoding: gzip\nendian: little\ndata file: volume.gz\n";
  std::FILE* text = std::fopen(file.c_str(), "wb");
  std::fwrite(header.data(), 1, header.size(), text);
  std::fclose(text);
  gzFile packed = gzopen((file.parent_path() / "volume.gz").c_str(), "wb6");
  for (std::size_t at = 0; at < voxels.size(); at += 1 << 20) {
    const std::size_t count = std::min<std::size_t>(voxels.size() - at, 1 << 20);
    gzwrite(packed, voxels.data() + at, static_cast<unsigned>(count * sizeof voxels[0]));
  }
  gzclose(packed);
}

void read_dicom_alone(const fs::path& folder) {
  vtkNew<vtkStringArray> files;
  for (const auto& entry : fs::directory_iterator(folder)) files->InsertNextValue(entry.path().string());
  vtkNew<vtkDICOMReader> reader;
  reader->SetFileNames(files);
  reader->SetMemoryRowOrderToFileNative();
  reader->AutoRescaleOff();
  reader->Update();
}

}  // namespace

int main(int arguments, char** argument) {
  const int n = arguments > 1 ? std::atoi(argument[1]) : 512;
  if (n < 2 || n > 1024) return std::fprintf(stderr, "usage: bench_data [VOXELS ALONG A SIDE, 2 to 1024]\n"), 2;
  std::string name = (fs::temp_directory_path() / "palpa-bench-XXXXXX").string();
  if (::mkdtemp(name.data()) == nullptr) return std::fprintf(stderr, "no temporary folder\n"), 1;
  const fs::path folder = name, series = folder / "series", nrrd = folder / "volume.nhdr", packed = folder / "volume.gz";
  fs::create_directory(series);
  {
    std::vector<std::int16_t> made = voxels(n);
    write_dicom(series, made, n);
    write_nrrd(nrrd, made, n);
  }
  print("DICOM series, beside vtkDICOMReader", shortest_s([&] { read_dicom_alone(series); }),
        shortest_s([&] { palpa::read_volume(series); }));
  const std::string gunzip = "gzip -dc '" + packed.string() + "' > /dev/null";
  print("gzip NRRD, beside gunzip", shortest_s([&] { static_cast<void>(std::system(gunzip.c_str())); }),
        shortest_s([&] { palpa::read_volume(nrrd); }));
  fs::remove_all(folder);
  return 0;
}
