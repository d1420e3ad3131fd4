#include "mutations.h"

#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <random>
#include <sstream>

#include "files.h"
#include "palpa/volume/read_series.h"
#include "palpa/volume/volume.h"

namespace palpa::test {
namespace {

std::string content(const fs::path& file) {
  std::ostringstream text;
  text << std::ifstream(file, std::ios::binary).rdbuf();
  return text.str();
}

// The most resident memory of this process, or of a child.
double peak_bytes_of(int who) {
  rusage usage{};
  ::getrusage(who, &usage);
  return 1024.0 * static_cast<double>(usage.ru_maxrss);
}

class Damage {
 public:
  explicit Damage(std::uint32_t seed) : random_(seed) {}

  std::size_t below(std::size_t n) {
    return std::uniform_int_distribution<std::size_t>(0, std::max<std::size_t>(n, 1) - 1)(random_);
  }

  /// Puts damage in the place of a file with this content.
  void put(const fs::path& file, const std::string& bytes) {
    switch (below(40)) {
      case 0: return write(file, "");
      case 1: return fs::create_symlink(file.filename(), file);
      case 2: return static_cast<void>(fs::create_directory(file));
      case 3: return;  // gone
      case 4: return write(file, bytes + bytes.substr(0, below(1 << 16)));
      default: return write(file, damaged(bytes));
    }
  }

 private:
  std::string damaged(std::string bytes) {
    if (bytes.empty()) return bytes;
    // Headers are small and matter most: half of the damage goes to the first 400 bytes.
    const auto place = [&] { return below(2) == 0 ? below(std::min<std::size_t>(bytes.size(), 400)) : below(bytes.size()); };
    switch (below(7)) {
      case 0: bytes.resize(place()); break;
      case 1:
        for (int n = 0; n < 4; ++n) bytes[place()] ^= static_cast<char>(1 << below(8));
        break;
      case 2:
        for (int n = 0; n < 3; ++n) bytes[place()] = static_cast<char>("09-9e\xff"[below(6)]);
        break;
      case 3: bytes.erase(place(), 1 + below(16)); break;
      case 4: bytes.insert(place(), std::string(1 + below(16), static_cast<char>(below(256)))); break;
      case 5: {
        const std::size_t at = place();
        std::fill_n(bytes.begin() + static_cast<std::ptrdiff_t>(at), std::min<std::size_t>(bytes.size() - at, 1 + below(64)),
                    '\0');
        break;
      }
      default: change_number(bytes); break;
    }
    return bytes;
  }

  /// A number of a header in text becomes another; of one in bytes, four bytes do.
  void change_number(std::string& bytes) {
    static constexpr const char* numbers[] = {"0",        "-1",         "1",          "7",     "65536",
                                              "99999999", "2147483647", "4294967296", "1e308", "nan"};
    const std::size_t near = below(std::min<std::size_t>(bytes.size(), 2000));
    const std::size_t from = bytes.find_first_of("0123456789", near);
    if (from != std::string::npos && from < near + 40) {
      const std::size_t end = std::min(bytes.find_first_not_of("0123456789.", from), bytes.size());
      bytes.replace(from, end - from, numbers[below(std::size(numbers))]);
      return;
    }
    static constexpr std::uint32_t values[] = {0, 1, 0x7fffffff, 0xffffffff, 0x01000000, 65536};
    const std::string four = bytes_of(values[below(std::size(values))], below(2) == 0);
    for (std::size_t n = 0; n < 4 && near + n < bytes.size(); ++n) bytes[near + n] = four[n];
  }

  static void write(const fs::path& file, const std::string& bytes) { std::ofstream(file, std::ios::binary) << bytes; }

  std::mt19937 random_;
};

struct Outcome {
  std::string refusal;       ///< empty: it was read
  double voxel_bytes = 0.0;  ///< of all fields
  double spent_s = 0.0;
};

Outcome look_at(VolumeRequest request, const std::string& frames, const ReadOptions& options, MutationResult& result) {
  Outcome outcome;
  const auto begin = std::chrono::steady_clock::now();
  const std::string place = request.files.front().string() + (frames.empty() ? ": " : "/");
  try {
    if (!frames.empty()) request.files = files_matching(request.files.front() / frames);
    const Volume volume = frames.empty() ? read_volume(request, options)
                                         : read_series(request, 0.1, BetweenFrames::linear, volume_reader(options));
    ++result.read;
    for (const VolumeField& field : volume.fields) {
      if (const GridView* grid = grid_of(*field.field)) {
        outcome.voxel_bytes += static_cast<double>(grid->geometry.voxels()) * grid->voxels.components *
                               static_cast<double>(size_of(grid->voxels.type));
      }
      const Vec3 middle_m = field.field->bounds_m().centre_m();
      const double value =
          field.field->components() == 1 ? field.field->scalar(middle_m).value : field.field->vector(middle_m).value.x;
      if (!std::isfinite(value)) result.wrong.push_back("a value that is not finite");
    }
  } catch (const std::exception& error) {
    const std::string text = error.what();
    ++result.refused;
    if (text.find("palpa-read") != std::string::npos) result.ended.push_back(text.substr(text.find(": ") + 2));
    if (text.rfind(place, 0) != 0 || text.find('\n') != std::string::npos || text.find("; ") == std::string::npos) {
      result.wrong.push_back(text);
    }
    outcome.refusal = text.substr(text.find(": ") + 2);
  }
  outcome.spent_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return outcome;
}

}  // namespace

MutationResult read_mutations(const SetToDamage& set, int count, std::uint32_t seed, const ReadOptions& options,
                              const fs::path& keep) {
  const TemporaryFolder made, work;
  const fs::path original = set.original(made);
  if (!fs::exists(original)) throw std::runtime_error(original.string() + " is not there");
  const bool is_folder = fs::is_directory(original);
  const fs::path set_folder = is_folder ? original : original.parent_path();
  const fs::path copy = work.path() / set_folder.filename();
  fs::copy(set_folder, copy, fs::copy_options::recursive);
  for (const auto& entry : fs::recursive_directory_iterator(work.path())) {
    if (entry.is_directory()) fs::permissions(entry.path(), fs::perms::owner_all, fs::perm_options::add);
  }
  VolumeRequest request = set.request;
  request.files = {is_folder ? copy : copy / original.filename()};

  std::vector<fs::path> targets;  // in the set's folder
  if (is_folder) {
    for (const auto& entry : fs::recursive_directory_iterator(original)) {
      if (entry.is_regular_file()) targets.push_back(entry.path().lexically_relative(set_folder));
    }
    std::sort(targets.begin(), targets.end());
  } else {
    // The file itself most often: it has the header.
    targets.assign(set.with.empty() ? 1 : 3, original.filename());
    targets.insert(targets.end(), set.with.begin(), set.with.end());
  }

  MutationResult result;
  const Outcome undamaged = look_at(request, set.frames, options, result);
  result = {};
  result.refused_undamaged = undamaged.refusal;
  result.true_peak_bytes = peak_bytes_of(RUSAGE_CHILDREN);
  Damage damage(seed);
  for (int n = 0; n < count; ++n) {
    const fs::path& chosen = targets[damage.below(targets.size())];
    const fs::path target = copy / chosen;
    const std::string bytes = content(set_folder / chosen);
    fs::remove_all(target);
    damage.put(target, bytes);
    const std::size_t said = result.wrong.size() + result.ended.size();
    // Until it becomes another program a child counts with the memory of this one, which has held larger volumes before.
    const double own_bytes = peak_bytes_of(RUSAGE_SELF);
    Outcome outcome = look_at(request, set.frames, options, result);
    // What takes long takes long again; where the machine was busy with others it does not.
    if (outcome.spent_s > options.idle_limit_s + 1.0) {
      MutationResult again;
      outcome.spent_s = std::min(outcome.spent_s, look_at(request, set.frames, options, again).spent_s);
    }
    result.slowest_s = std::max(result.slowest_s, outcome.spent_s);
    if (outcome.spent_s > options.idle_limit_s + 1.0)
      result.wrong.push_back("a file kept it for " + std::to_string(outcome.spent_s) + " s");
    // What is refused undamaged, too, needs no memory but that of the program; damaged to a larger volume, that of its voxels.
    const double before_bytes = std::max({result.peak_bytes, result.true_peak_bytes, own_bytes});
    const double need_bytes = result.true_peak_bytes + std::max(outcome.voxel_bytes - undamaged.voxel_bytes, 0.0);
    result.peak_bytes = peak_bytes_of(RUSAGE_CHILDREN);
    if (undamaged.refusal.empty() && result.peak_bytes > std::max(before_bytes, 3.0 * need_bytes)) {
      result.wrong.push_back("more than 3 times the memory of the undamaged file: " +
                             std::to_string(std::lround(result.peak_bytes / 1e6)) + " MB");
    }
    if (result.wrong.size() + result.ended.size() > said && !keep.empty()) {
      const fs::path kept = keep / std::to_string(n);
      fs::remove_all(kept);
      fs::create_directories(kept);
      fs::copy(copy, kept, fs::copy_options::recursive | fs::copy_options::copy_symlinks);
    }
    fs::remove_all(target);
    std::ofstream(target, std::ios::binary) << bytes;
  }
  return result;
}

}  // namespace palpa::test
