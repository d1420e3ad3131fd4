#include "files.h"

#include <unistd.h>
#include <zlib.h>

#include <cstdlib>
#include <fstream>

#include "tests/shared_data.h"

namespace palpa::test {

TemporaryFolder::TemporaryFolder() {
  std::string name = (fs::temp_directory_path() / "palpa-test-XXXXXX").string();
  if (::mkdtemp(name.data()) == nullptr) throw std::runtime_error("no temporary folder");
  path_ = name;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code none;
  fs::remove_all(path_, none);
}

fs::path TemporaryFolder::write(const std::string& name, const std::string& bytes) const {
  std::ofstream(path_ / name, std::ios::binary) << bytes;
  return path_ / name;
}

ReadOptions built_reader() {
  ReadOptions options;
  const char* bin = std::getenv("PALPA_BIN");
  const char* reader = std::getenv("PALPA_READER");
  if (bin != nullptr && fs::exists(fs::path(bin) / "palpa-read"))
    options.reader = fs::path(bin) / "palpa-read";
  else if (reader != nullptr)
    options.reader = reader;
  return options;
}

fs::path shared_file(const std::string& name) {
  const fs::path file = shared_data(name);
  return fs::exists(file) ? file : fs::path();
}

void ReaderTest::SetUp() {
  options_ = built_reader();
  if (options_.reader.empty()) GTEST_SKIP() << "palpa-read is not built: set PALPA_READER=ON, or $PALPA_READER to its path";
}

Volume ReaderTest::read(const fs::path& file, VolumeRequest request) const {
  request.files = {file};
  return read_volume(request, options_);
}

std::string error_of(const std::function<void()>& act) {
  try {
    act();
  } catch (const LoadError& error) {
    const std::string text = error.what();
    EXPECT_EQ(text.find('\n'), std::string::npos) << text;
    EXPECT_NE(text.find("; "), std::string::npos) << "says not what would be right: " << text;
    return text;
  }
  ADD_FAILURE() << "nothing was thrown";
  return {};
}

std::string gzipped(const std::string& bytes) {
  z_stream stream{};
  deflateInit2(&stream, 6, Z_DEFLATED, 15 + 16, 8, Z_DEFAULT_STRATEGY);
  std::string out(deflateBound(&stream, bytes.size()), '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  deflate(&stream, Z_FINISH);
  out.resize(stream.total_out);
  deflateEnd(&stream);
  return out;
}

std::string gunzipped(const std::string& bytes) {
  z_stream stream{};
  inflateInit2(&stream, 15 + 16);
  std::string out(std::size_t{1} << 24, '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  const int end = inflate(&stream, Z_FINISH);
  out.resize(end == Z_STREAM_END && stream.avail_in == 0 ? stream.total_out : 0);
  inflateEnd(&stream);
  return out;
}

FileGrid sheared_grid() { return {{6, 5, 4}, {{{-2.0, 0.3, 0.4}, {0.5, 1.7, -0.6}, {0.1, 0.2, 3.0}}}, {11.0, -7.0, 5.0}}; }

void expect_linear(const Field& field, const FileGrid& grid, const std::function<Vec3(const Vec3&)>& to_world_m,
                   const Linear& linear) {
  const double largest = norm(linear.gradient);
  for (int n = 0; n < 60; ++n) {
    // Points of a lattice that meets no voxel.
    const auto part = [&](double step, int axis) {
      return std::fmod(0.01 + n * step, 1.0) * static_cast<double>(grid.dims[axis] - 1);
    };
    const Vec3 index{part(0.618034, 0), part(0.754878, 1), part(0.569840, 2)};
    const Vec3 world_m = to_world_m(grid.at(index));
    const ScalarSample sample = field.scalar(world_m);
    ASSERT_TRUE(sample.inside) << "at index " << index.x << " " << index.y << " " << index.z;
    EXPECT_NEAR(sample.value, linear(world_m), 1e-5 * (1 + std::abs(linear(world_m))));
    EXPECT_LT(distance(sample.gradient, linear.gradient), 1e-3 * largest);
  }
  for (const Vec3& index : {Vec3{-0.5, 0, 0}, Vec3{0, -0.5, 0}, Vec3{0, 0, static_cast<double>(grid.dims[2]) - 0.5}}) {
    EXPECT_FALSE(field.scalar(to_world_m(grid.at(index))).inside);
  }
}

int child_process() {
  std::error_code gone;
  for (fs::directory_iterator task("/proc/self/task", gone), end; !gone && task != end; task.increment(gone)) {
    int child = 0;
    if (std::ifstream(task->path() / "children") >> child) return child;
  }
  return 0;
}

bool warns_of(const Volume& volume, const std::string& part) {
  for (const std::string& warning : volume.warnings) {
    if (warning.find(part) != std::string::npos) return true;
  }
  return false;
}

std::string all_warnings(const Volume& volume) {
  std::string all;
  for (const std::string& warning : volume.warnings) all += "  " + warning + "\n";
  return all;
}

}  // namespace palpa::test
