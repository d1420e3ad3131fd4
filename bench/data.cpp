// Opening data beside what the library or tool for it needs alone: a DICOM series, a compressed NRRD and bare numbers, all made
// here. Series and NRRD with checksums, as a run that is recorded reads them, and without.
#include <palpa/palpa.h>
#include <stdlib.h>
#include <vtkDICOMCTGenerator.h>
#include <vtkDICOMReader.h>
#include <vtkDICOMWriter.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkSmartPointer.h>
#include <vtkStringArray.h>
#include <zlib.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "palpa/study/run.h"

namespace fs = std::filesystem;

namespace {

constexpr int repeats = 5;

/// The shortest of some runs [s]: what the work takes when nothing else is in the way. What it makes is let go of only when the
/// clock has been read.
template <class Work>
double shortest_s(const Work& work) {
  double shortest = 1e9;
  for (int n = 0; n < repeats; ++n) {
    const auto start = std::chrono::steady_clock::now();
    [[maybe_unused]] const auto made = work();
    shortest = std::min(shortest, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  }
  return shortest;
}

void print(const char* what, double alone_s, double ours_s) {
  std::printf("%-44s alone %6.3f s, ours %6.3f s: %.2f times\n", what, alone_s, ours_s, ours_s / alone_s);
  std::fflush(stdout);
}

bool run(const std::string& command) {
  const bool done = std::system((command + " > /dev/null 2>&1").c_str()) == 0;
  if (!done) std::fprintf(stderr, "failed: %s\n", command.c_str());
  return done;
}

double read_s(const fs::path& file, bool checksums) {
  palpa::VolumeRequest request;
  request.files = {file};
  return shortest_s([&] { return palpa::read_volume(request, {.checksums = checksums}); });
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

/// Bare numbers, and a scene to feel them with.
void write_raw(const fs::path& folder, const std::vector<std::int16_t>& voxels, int n) {
  std::FILE* file = std::fopen((folder / "volume.raw").c_str(), "wb");
  std::fwrite(voxels.data(), sizeof voxels[0], voxels.size(), file);
  std::fclose(file);
  const std::string size = std::to_string(n);
  std::FILE* scene = std::fopen((folder / "raw.toml").c_str(), "wb");
  std::fprintf(
      scene,
      "palpa = 1\n[volume.v]\nfile = \"volume.raw\"\ntype = \"int16\"\ndims = [%d, %d, %d]\nspacing_m = [0.0005, 0.0005, "
      "0.0005]\n[workspace]\nfit = \"v\"\n[[mode]]\nname = \"inside\"\ntype = \"viscosity\"\nfield = \"v\"\ndrag_ns_per_m = "
      "1\n",
      n, n, n);
  std::fclose(scene);
}

vtkSmartPointer<vtkImageData> read_dicom_alone(const fs::path& folder) {
  vtkNew<vtkStringArray> files;
  for (const auto& entry : fs::directory_iterator(folder)) files->InsertNextValue(entry.path().string());
  vtkNew<vtkDICOMReader> reader;
  reader->SetFileNames(files);
  reader->SetMemoryRowOrderToFileNative();
  reader->AutoRescaleOff();
  reader->Update();
  return reader->GetOutput();
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
    write_raw(folder, made, n);
  }
  const double vtk_s = shortest_s([&] { return read_dicom_alone(series); });
  print("DICOM series, beside vtkDICOMReader", vtk_s, read_s(series, false));
  print("the same, with checksums", vtk_s, read_s(series, true));
  const double gunzip_s = shortest_s([&] { return run("gzip -dc '" + packed.string() + "'"); });
  print("gzip NRRD, beside gunzip", gunzip_s, read_s(nrrd, false));
  print("the same, with checksums", gunzip_s, read_s(nrrd, true));

  const std::string palpa = "'" + (fs::read_symlink("/proc/self/exe").parent_path() / "palpa").string() + "' ";
  const std::string raw = "'" + (folder / "volume.raw").string() + "'", size = std::to_string(n);
  std::printf("%-44s %.1f ms (the program starts in %.1f ms)\n", "palpa info of bare numbers",
              1e3 * shortest_s([&] {
                return run(palpa + "info " + raw + " --set type=int16 --set 'dims=[" + size + "," + size + "," + size + "]'");
              }),
              1e3 * shortest_s([&] { return run(palpa + "--version"); }));
  const std::string copy = "cp " + raw + " '" + (folder / "copy.raw").string() + "'";
  print("palpa run of bare numbers for 1 ms, beside cp", shortest_s([&] {
          fs::remove(folder / "copy.raw");
          return run(copy);
        }),
        shortest_s(
            [&] { return run(palpa + "run '" + (folder / "raw.toml").string() + "' --hand sim:stroke --duration-s 0.001"); }));
  fs::remove_all(folder);
  return 0;
}
