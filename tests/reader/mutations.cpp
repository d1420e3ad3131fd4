#include "mutations.h"

#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <random>
#include <sstream>

#include "files.h"
#include "palpa/data/read_series.h"
#include "palpa/data/volume.h"
#include "palpa/file/octave_places.h"
#include "palpa/file/sliced_file.h"
#include "palpa/file/store_chunks.h"
#include "palpa/file/store_survey.h"

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

// The processor time of this process and its ended children, independent of other load.
double processor_s() {
  double sum_s = 0.0;
  for (const int who : {RUSAGE_SELF, RUSAGE_CHILDREN}) {
    rusage usage{};
    ::getrusage(who, &usage);
    for (const timeval& time : {usage.ru_utime, usage.ru_stime})
      sum_s += static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
  }
  return sum_s;
}

struct Outcome {
  std::string refusal;  ///< empty: it was read
  double voxel_bytes = 0.0;
  double spent_s = 0.0;
};

/// Reads all chunks of a store, and what info says of it.
void read_store(const fs::path& store, const ReadOptions& options, MutationResult& result) {
  StoreReader reader(store, options, 4);
  const StoreContents& contents = reader.contents();
  for (std::size_t n = 0; n < contents.octaves.size(); ++n) {
    const StoreOctave& octave = contents.octaves[n];
    std::vector<StoreChunk> chunks;
    const auto along = chunks_along(octave);
    // A damaged length may be of millions of chunks.
    for (std::int64_t k = 0; k < std::min<std::int64_t>(along[2], 4); ++k)
      for (std::int64_t j = 0; j < std::min<std::int64_t>(along[1], 4); ++j)
        for (std::int64_t i = 0; i < std::min<std::int64_t>(along[0], 4); ++i)
          chunks.push_back({.octave = static_cast<std::int32_t>(n), .at = {i, j, k}});
    if (octave.facts[0] > 0) chunks.push_back({.octave = static_cast<std::int32_t>(n), .facts = true});
    read_chunks(reader, chunks, [&](const StoreRead& read, std::span<const std::byte> content) {
      if ((read.state == ChunkState::present) == content.empty()) result.wrong.push_back("a chunk without content");
      if ((read.state == ChunkState::damaged) == read.sentence.empty())
        result.wrong.push_back("a damaged chunk without a sentence");
      if (read.sentence.find('\n') != std::string::npos) result.wrong.push_back(read.sentence);
    });
  }
  octave_places(reader);
  survey(reader, 2.0, 2.0);
}

/// Reads all rows of a file that gives them, unless the damage claims too many.
void read_rows(const VolumeRequest& request, const ReadOptions& options) {
  const auto file = open_sliced_file(request, options);
  for (std::size_t f = 0; file && f < file->fields.size(); ++f) {
    const SlicedFile::Field& field = file->fields[f];
    const auto& n = field.grid.dims;
    const std::size_t row = static_cast<std::size_t>(n[0] * field.components) * size_of(field.type);
    std::vector<std::byte> rows(row);
    for (std::int64_t k = 0; k < std::min<std::int64_t>(n[2], 40); ++k) file->read(f, {k, 1, n[1] - 1, 1}, rows.data());
  }
}

Outcome look_at(VolumeRequest request, const std::string& frames, const ReadOptions& options, MutationResult& result,
                bool chunks = false) {
  Outcome outcome;
  const double begin_s = processor_s();
  const std::string place = request.files.front().string() + (frames.empty() ? ": " : "/");
  try {
    if (chunks) {
      read_store(request.files.front(), options, result);
      ++result.read;
      outcome.spent_s = processor_s() - begin_s;
      return outcome;
    }
    if (frames.empty()) read_rows(request, options);
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
  outcome.spent_s = processor_s() - begin_s;
  return outcome;
}

}  // namespace

class DamagedSet::State {
 public:
  State(const SetToDamage& set, const ReadOptions& options) : set_(set), options_(options), original_(set.original(made_)) {
    if (!fs::exists(original_)) throw std::runtime_error(original_.string() + " is not there");
    const bool is_folder = fs::is_directory(original_);
    set_folder_ = is_folder ? original_ : original_.parent_path();
    copy_ = work_.path() / set_folder_.filename();
    fs::copy(set_folder_, copy_, fs::copy_options::recursive);
    for (const auto& entry : fs::recursive_directory_iterator(work_.path())) {
      if (entry.is_directory()) fs::permissions(entry.path(), fs::perms::owner_all, fs::perm_options::add);
    }
    request_ = set.request;
    request_.files = {is_folder ? copy_ : copy_ / original_.filename()};
    if (is_folder) {
      for (const auto& entry : fs::recursive_directory_iterator(original_)) {
        if (entry.is_regular_file()) targets_.push_back(entry.path().lexically_relative(set_folder_));
      }
      std::sort(targets_.begin(), targets_.end());
    } else {
      // The file itself most often: it has the header.
      targets_.assign(set.with.empty() ? 1 : 3, original_.filename());
      targets_.insert(targets_.end(), set.with.begin(), set.with.end());
    }
    MutationResult unused;
    // Damage to the first bytes leaves a file of no format, which goes through all readers: their own memory is that of no
    // file.
    if (!is_folder) {
      VolumeRequest formless;
      formless.files = {work_.path() / ("formless" + original_.extension().string())};
      std::ofstream(formless.files.front()) << std::string(1024, ' ');
      look_at(formless, set_.frames, options_, unused, set_.chunks);
    }
    undamaged_ = look_at(request_, set_.frames, options_, unused, set_.chunks);
    true_peak_bytes_ = peak_bytes_of(RUSAGE_CHILDREN);
  }

  void damage_once(Damage& damage, const fs::path& keep, MutationResult& result) {
    result.refused_undamaged = undamaged_.refusal;
    result.true_peak_bytes = true_peak_bytes_;
    const fs::path& chosen = targets_[damage.below(targets_.size())];
    const fs::path target = copy_ / chosen;
    const std::string bytes = content(set_folder_ / chosen);
    fs::remove_all(target);
    damage.put(target, bytes);
    const std::size_t said = result.wrong.size() + result.ended.size();
    // Until exec a child counts with this process's memory, which has held larger volumes.
    const double own_bytes = peak_bytes_of(RUSAGE_SELF);
    const double before_bytes = std::max({peak_bytes_of(RUSAGE_CHILDREN), true_peak_bytes_, own_bytes});
    const Outcome outcome = look_at(request_, set_.frames, options_, result, set_.chunks);
    result.slowest_s = std::max(result.slowest_s, outcome.spent_s);
    if (outcome.spent_s > options_.idle_limit_s + 1.0)
      result.wrong.push_back("a file kept it for " + std::to_string(outcome.spent_s) + " s of the processor");
#if defined(__SANITIZE_ADDRESS__)
    // Freed memory that detects later use, and margins of small allocations: ten times the 40 MB of a case.
    constexpr double kept_bytes = 512e6;
#else
    constexpr double kept_bytes = 0.0;
#endif
    // Refused undamaged files need the program's memory only; damage to a larger volume, that of its voxels.
    const double need_bytes = true_peak_bytes_ + std::max(outcome.voxel_bytes - undamaged_.voxel_bytes, 0.0);
    result.peak_bytes = peak_bytes_of(RUSAGE_CHILDREN);
    if (undamaged_.refusal.empty() && result.peak_bytes > std::max(before_bytes, 3.0 * need_bytes + kept_bytes)) {
      result.wrong.push_back("more than 3 times the memory of the undamaged file: " +
                             std::to_string(std::lround(result.peak_bytes / 1e6)) + " MB");
    }
    if (result.wrong.size() + result.ended.size() > said && !keep.empty()) {
      fs::remove_all(keep);
      fs::create_directories(keep);
      fs::copy(copy_, keep, fs::copy_options::recursive | fs::copy_options::copy_symlinks);
    }
    fs::remove_all(target);
    std::ofstream(target, std::ios::binary) << bytes;
  }

 private:
  SetToDamage set_;
  ReadOptions options_;
  TemporaryFolder made_, work_;
  fs::path original_, set_folder_, copy_;
  VolumeRequest request_;
  std::vector<fs::path> targets_;
  Outcome undamaged_;
  double true_peak_bytes_ = 0.0;
};

DamagedSet::DamagedSet(const SetToDamage& set, const ReadOptions& options) : state_(std::make_unique<State>(set, options)) {}
DamagedSet::~DamagedSet() = default;

void DamagedSet::damage_once(Damage& damage, const fs::path& keep, MutationResult& result) {
  state_->damage_once(damage, keep, result);
}

MutationResult read_mutations(const SetToDamage& set, int count, std::uint32_t seed, const ReadOptions& options) {
  DamagedSet damaged(set, options);
  std::mt19937 random(seed);
  Damage damage(
      [&](std::size_t n) { return std::uniform_int_distribution<std::size_t>(0, std::max<std::size_t>(n, 1) - 1)(random); });
  MutationResult result;
  for (int n = 0; n < count; ++n) damaged.damage_once(damage, {}, result);
  return result;
}

}  // namespace palpa::test
