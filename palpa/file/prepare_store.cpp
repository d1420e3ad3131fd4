#include "palpa/file/prepare_store.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <optional>
#include <thread>
#include <utility>

#include "palpa/base/input_file.h"
#include "palpa/file/fetch_process.h"
#include "palpa/file/prepare_unit.h"
#include "palpa/file/store_histogram.h"

namespace palpa {
namespace {

namespace fs = std::filesystem;
using namespace detail;
using Clock = std::chrono::steady_clock;

constexpr std::size_t most_named = 20;  // wrong chunks of a check. More: pages of them; fewer: the pattern is hidden

static_assert(sizeof(ChunkFacts) == 4 * sizeof(double), "facts are stored as they lie");

std::string name_of_chunk(int octave, const StoreChunk& chunk) {
  return "octave " + std::to_string(octave) + ", chunk " + std::to_string(chunk.at[2]) + "/" + std::to_string(chunk.at[1]) +
         "/" + std::to_string(chunk.at[0]) +
         (chunk.frame > 0 || chunk.field > 0
              ? " of frame " + std::to_string(chunk.frame) + ", field " + std::to_string(chunk.field)
              : "");
}

bool same(double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); }

/// Channel of a field's first component.
int first_channel(const UnitPlan& plan, int field) {
  int channel = 0;
  for (int f = 0; f < field; ++f) channel += plan.components[static_cast<std::size_t>(f)];
  return channel;
}

class Preparation {
 public:
  Preparation(const fs::path& store, const PrepareOptions& options, bool checks)
      : store_(store), target_(options.into.empty() ? store : options.into), options_(options), checks_(checks) {
    refuse_web_address(store, "palpa prepare");
    refuse_web_address(target_, "palpa prepare");
    StoreReader reader(store, options.read, 1);
    contents_ = reader.contents();
    plan_ = unit_plan(contents_, read_image(store));
    const int cores = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
    threads_ = std::clamp(options.threads > 0 ? options.threads : options.is_one_part ? 1 : cores, 1, 256);
    files_ = std::make_unique<PreparedFiles>(plan_, target_);
    result_.unit = plan_.unit, result_.threads = threads_;
    result_.first_octave = plan_.base + 1, result_.last_octave = plan_.last;
  }

  PreparedStore prepare() {
    make_target();
    const std::int64_t first = options_.part.first(plan_.items()), end = options_.part.end(plan_.items());
    std::vector<std::int64_t> missing;
    for (std::int64_t n = first; n < end; ++n) {
      if (!files_->is_done(plan_.item(n))) missing.push_back(n);
    }
    result_.units = end - first;
    result_.units_before = result_.units - static_cast<std::int64_t>(missing.size());
    walk_units(missing);
    if (!options_.is_one_part) finish();
    for (std::int64_t n = 0; n < plan_.items(); ++n) result_.units_missing += !files_->is_done(plan_.item(n));
    return done();
  }

  PreparedStore check() {
    if (!contents_.prepared) throw LoadError(store_.string() + ": is not prepared; prepare it first (palpa prepare)");
    std::vector<std::int64_t> all;
    for (std::int64_t n = options_.part.first(plan_.items()); n < options_.part.end(plan_.items()); ++n) all.push_back(n);
    result_.units = static_cast<std::int64_t>(all.size());
    walk_units(all);
    if (!options_.is_one_part && plan_.last > plan_.top) walk_coarsest();
    return done();
  }

 private:
  PreparedStore done() {
    result_.seconds = std::chrono::duration<double>(Clock::now() - begin_).count();
    result_.chunks_read = chunks_read_, result_.chunks_written = files_->written();
    return result_;
  }

  void make_target() {
    std::error_code error;
    if (!options_.into.empty()) {
      fs::create_directories(target_, error);
      if (error)
        throw LoadError(target_.string() + ": cannot be made (" + error.message() + "); name a folder that may be written to");
      const fs::path group = target_ / ".zgroup";
      if (plan_.image.zarr == 2 && !InputFile(group).is_open()) write_whole(group, group_metadata(2), Existing::replaced);
      if (fs::equivalent(store_, target_, error))
        throw LoadError(target_.string() + ": is the store itself; leave out --into, or name another folder");
    }
    files_->make();
  }

  bool goes_on() const noexcept { return !options_.stop || !*options_.stop; }

  std::unique_ptr<UnitWorker> new_worker(const fs::path& store, int shift) {
    auto worker = std::make_unique<UnitWorker>();
    worker->reader = std::make_unique<StoreReader>(store, options_.read, reader_slots(plan_));
    if (checks_) worker->compared = std::make_unique<StoreReader>(store, options_.read, 1);
    worker->stream = std::make_unique<ChunkStream>(*worker->reader, [this] { return goes_on(); });
    worker->walk = std::make_unique<UnitWalk>(plan_, contents_, *worker->stream, sink_of(*worker), shift);
    return worker;
  }

  WalkSink sink_of(UnitWorker& worker) {
    WalkSink sink;
    sink.facts = [this](int octave, const VoxelIndex& at, const ChunkFacts& facts) {
      ++chunks_read_;
      if (ChunkFacts* to = facts_.at(octave, at)) *to = facts;
    };
    sink.finest = [&worker](const VoxelKind& kind, const VoxelBlock& block, const VoxelIndex& low, const VoxelIndex& size) {
      worker.histogram.add(kind, block, low, size);
    };
    sink.voxels = [this, &worker](int octave, const VoxelIndex& at, const VoxelBlock& chunk) {
      checks_ ? compare(worker, octave, at, chunk) : write(worker, octave, at, chunk);
    };
    sink.damaged = [this](const StoreRead& read) {
      const std::string what = name_of_chunk(read.chunk.octave, read.chunk) + " is damaged (" + read.sentence + ")";
      if (!checks_) throw LoadError(store_.string() + ": " + what + "; get this file again, or write the store anew");
      add_wrong(what);
    };
    return sink;
  }

  void write(UnitWorker& worker, int octave, const VoxelIndex& at, const VoxelBlock& chunk) {
    const std::size_t number_bytes = size_of(plan_.kind.type);
    const auto components = static_cast<std::size_t>(plan_.components[static_cast<std::size_t>(item_.field)]);
    std::vector<std::byte> apart;
    for (std::size_t c = 0; c < components; ++c) {
      std::span<const std::byte> voxels = chunk.voxels;
      if (components > 1) {
        apart.resize(chunk.voxels.size() / components);
        for (std::size_t n = 0; n < apart.size() / number_bytes; ++n)
          std::memcpy(apart.data() + n * number_bytes, chunk.voxels.data() + (n * components + c) * number_bytes, number_bytes);
        voxels = apart;
      }
      const std::vector<std::byte> narrow = narrowed(plan_.stored, voxels);
      if (!narrow.empty()) voxels = narrow;
      PackedChunk packed{octave, first_channel(plan_, item_.field) + static_cast<int>(c), at,
                         packed_chunk(voxels, stored_bytes(plan_.stored, plan_.kind.type))};
      files_->has_shards(octave) ? worker.packed.push_back(std::move(packed))
                                 : files_->write(item_.frame, packed, worker.batch);
    }
  }

  void add_wrong(const std::string& sentence) {
    const std::lock_guard lock(mutex_);
    ++result_.wrong;
    if (result_.wrong_chunks.size() < most_named) result_.wrong_chunks.push_back(sentence);
  }

  /// Chunk or facts from the store, for a comparison.
  StoreRead read_again(StoreReader& reader, const StoreChunk& chunk) const {
    reader.request(chunk, 0);
    for (;;) {
      if (!goes_on()) throw LoadError("interrupted");
      if (const auto read = reader.next(0.2)) return *read;
    }
  }

  void compare(UnitWorker& worker, int octave, const VoxelIndex& at, const VoxelBlock& chunk) {
    const StoreChunk place{.octave = octave, .frame = item_.frame, .field = item_.field, .at = at};
    const StoreRead read = read_again(*worker.compared, place);
    if (read.state == ChunkState::absent) return add_wrong(name_of_chunk(octave, place) + " is missing");
    if (read.state == ChunkState::damaged)
      return add_wrong(name_of_chunk(octave, place) + " is damaged (" + read.sentence + ")");
    const std::span<const std::byte> content = worker.compared->content(0);
    const std::size_t bytes =
        static_cast<std::size_t>(plan_.components[static_cast<std::size_t>(item_.field)]) * size_of(plan_.kind.type);
    const std::size_t row = static_cast<std::size_t>(chunk.valid[0]) * bytes;
    for (std::int64_t k = 0; k < chunk.valid[2]; ++k)
      for (std::int64_t j = 0; j < chunk.valid[1]; ++j) {
        const std::size_t from = static_cast<std::size_t>((k * chunk.size[1] + j) * chunk.size[0]) * bytes;
        if (std::memcmp(content.data() + from, chunk.voxels.data() + from, row) != 0)
          return add_wrong(name_of_chunk(octave, place) + " is not the mean of octave " + std::to_string(octave - 1));
      }
  }

  /// Compares the facts of a box with those of the store.
  void compare_facts(UnitWorker& worker, int octave, const VoxelIndex& first, const VoxelIndex& end) {
    const PlannedOctave& o = plan_.octaves[static_cast<std::size_t>(octave)];
    for_each_index(first, end, [&](const VoxelIndex& at) {
      const StoreChunk place{.octave = octave, .frame = item_.frame, .field = item_.field, .facts = true, .at = at};
      const StoreRead read = read_again(*worker.compared, place);
      const std::string name = "facts of " + name_of_chunk(octave, place);
      if (read.state != ChunkState::present)
        return add_wrong(name + (read.state == ChunkState::absent ? " are missing" : " are damaged (" + read.sentence + ")"));
      const std::byte* next = worker.compared->content(0).data();
      for_each_index({}, o.facts, [&](const VoxelIndex& inside) {
        ChunkFacts stored;
        std::memcpy(&stored, next, sizeof stored);
        next += sizeof stored;
        const VoxelIndex chunk{at[0] * o.facts[0] + inside[0], at[1] * o.facts[1] + inside[1], at[2] * o.facts[2] + inside[2]};
        const ChunkFacts* found = facts_.at(octave, chunk);
        if (!found || chunk[0] >= o.chunks[0] || chunk[1] >= o.chunks[1] || chunk[2] >= o.chunks[2]) return;
        const StoreChunk voxels{.octave = octave, .frame = item_.frame, .field = item_.field, .at = chunk};
        if (!same(stored.crc32, found->crc32))
          add_wrong(name_of_chunk(octave, voxels) + " is lost or was changed: other checksum than when it was prepared");
        else if (!same(stored.min, found->min) || !same(stored.max, found->max) || !same(stored.rms, found->rms))
          add_wrong("facts of " + name_of_chunk(octave, voxels) + " are wrong");
      });
    });
  }

  /// Histogram of the unit that was walked.
  DyadicHistogram histogram_of_unit() {
    DyadicHistogram whole;
    for (auto& worker : workers_) whole.merge(std::exchange(worker->histogram, {}));
    return whole;
  }

  void compare_histogram(const UnitPlan::Item& item, const DyadicHistogram& found) {
    const std::string name = "the histogram of unit " + std::to_string(item.at[2]) + "/" + std::to_string(item.at[1]) + "/" +
                             std::to_string(item.at[0]) + " of frame " + std::to_string(item.frame) + ", field " +
                             std::to_string(item.field);
    try {
      const std::optional<DyadicHistogram> stored = files_->histogram(item);
      if (stored != found) add_wrong(name + (stored ? " is wrong" : " is missing"));
    } catch (const LoadError& error) {
      add_wrong(error.what());
    }
  }

  void walk_units(const std::vector<std::int64_t>& numbers) {
    if (numbers.empty()) return;
    workers_.clear();
    for (int n = 0; n < threads_; ++n) workers_.push_back(new_worker(store_, 0));
    done_items_ = 0, items_ = numbers.size();
    for (const std::int64_t number : numbers) {
      walk_unit(plan_.item(number));
      ++done_items_;
    }
    workers_.clear();
  }

  void show(double share_of_item) const {
    if (options_.progress) options_.progress((static_cast<double>(done_items_) + share_of_item) / static_cast<double>(items_));
  }

  /// Facts' chunks of a unit.
  std::array<VoxelIndex, 2> facts_range(int octave) const {
    const PlannedOctave& o = plan_.octaves[static_cast<std::size_t>(octave)];
    std::array<VoxelIndex, 2> range{};
    for (std::size_t a = 0; a < 3; ++a) {
      const std::int64_t chunks = (plan_.unit[a] >> octave) / o.reach[a];
      range[0][a] = item_.at[a] * chunks / o.facts[a];
      range[1][a] = (std::min((item_.at[a] + 1) * chunks, o.chunks[a]) + o.facts[a] - 1) / o.facts[a];
    }
    return range;
  }

  void walk_unit(const UnitPlan::Item& item) {
    const std::int64_t wrong_before = result_.wrong;
    item_ = item;
    for (int n = 0; n <= plan_.top; ++n) {
      const PlannedOctave& o = plan_.octaves[static_cast<std::size_t>(n)];
      VoxelIndex first{}, size{};
      for (std::size_t a = 0; a < 3; ++a) size[a] = (plan_.unit[a] >> n) / o.reach[a], first[a] = item.at[a] * size[a];
      facts_.set(n, first, size);
    }
    for (auto& worker : workers_) worker->walk->set_item(item.frame, item.field, plan_.base);
    for (int n = 0; n <= plan_.top && n <= plan_.base; ++n) {
      if (n < plan_.base || plan_.base >= plan_.top) read_facts(n);
    }
    if (plan_.base < plan_.top) make_octaves();
    for (auto& worker : workers_) worker->batch.finish();
    FileBatch batch;
    if (!checks_) files_->finish_shards(batch);
    const DyadicHistogram histogram = histogram_of_unit();
    if (!checks_) files_->write_histogram(item, histogram, batch);
    for (int n = 0; n <= plan_.top; ++n) {
      const auto [first, end] = facts_range(n);
      checks_ ? compare_facts(*workers_[0], n, first, end)
              : files_->write_facts(n, item.frame, item.field, first, end, facts_, batch);
    }
    batch.finish();
    // Of a damaged or changed chunk it differs as well, which is said already.
    if (checks_ && result_.wrong == wrong_before) compare_histogram(item, histogram);
    VoxelIndex valid{};
    for (std::size_t a = 0; a < 3; ++a)
      valid[a] = std::min(plan_.unit[a], plan_.octaves[0].dims[a] - item.at[a] * plan_.unit[a]);
    result_.voxels += valid[0] * valid[1] * valid[2];
  }

  void read_facts(int octave) {
    const auto [first, end] = plan_.blocks_in(item_, octave);
    std::vector<VoxelIndex> blocks;
    for_each_index(first, end, [&](const VoxelIndex& at) { blocks.push_back(at); });
    on_workers(threads_, static_cast<std::int64_t>(blocks.size()), [&](int worker, std::int64_t n) {
      const VoxelIndex& at = blocks[static_cast<std::size_t>(n)];
      workers_[static_cast<std::size_t>(worker)]->walk->read_facts(octave, at, {at[0] + 1, at[1] + 1, at[2] + 1});
    });
  }

  void make_octaves() {
    const auto [first, end] = plan_.blocks_in(item_, plan_.task);
    std::vector<VoxelIndex> tasks;
    for_each_index(first, end, [&](const VoxelIndex& at) { tasks.push_back(at); });
    std::map<VoxelIndex, VoxelBlock> ready;
    std::map<std::int64_t, std::vector<PackedChunk>> for_shards;  // of tasks whose turn has not come: shards have one order
    std::int64_t next = 0, done = 0;
    on_workers(threads_, static_cast<std::int64_t>(tasks.size()), [&](int worker, std::int64_t n) {
      UnitWorker& own = *workers_[static_cast<std::size_t>(worker)];
      VoxelBlock block = own.walk->made(plan_.task, tasks[static_cast<std::size_t>(n)]);
      const std::lock_guard lock(mutex_);
      ready.emplace(tasks[static_cast<std::size_t>(n)], std::move(block));
      for_shards.emplace(n, std::move(own.packed));
      own.packed.clear();
      for (auto turn = for_shards.begin(); turn != for_shards.end() && turn->first == next;
           turn = for_shards.erase(turn), ++next)
        for (const PackedChunk& chunk : turn->second) files_->append(item_.frame, chunk);
      show(static_cast<double>(++done) / static_cast<double>(tasks.size()));
    });
    UnitWorker& own = *workers_[0];
    const auto [top_first, top_end] = plan_.blocks_in(item_, plan_.top);
    for_each_index(top_first, top_end, [&](const VoxelIndex& at) {
      own.walk->emit_facts(plan_.top, at, own.walk->made_of(plan_.top, at, plan_.task, ready));
    });
    for (const PackedChunk& chunk : own.packed) files_->append(item_.frame, chunk);
    own.packed.clear();
  }

  /// Octaves behind those of units, from the last of these, and the attributes.
  void finish() {
    AddedOctaves added{.first = plan_.base + 1, .own_from = plan_.base + 1, .unit = plan_.unit};
    if (!options_.into.empty()) added.beside = store_.filename().empty() ? store_.parent_path().filename() : store_.filename();
    for (int n = plan_.base + 1; n <= plan_.top; ++n) added.paths.push_back(plan_.path_of(n));
    // The reader finds octaves and facts by the attributes.
    const bool are_listed = plan_.image.own_from == added.own_from && static_cast<int>(contents_.octaves.size()) > plan_.last;
    if (plan_.last > plan_.top) {
      if (!are_listed) write_attributes(added);
      walk_coarsest();
      for (int n = std::max(plan_.top, plan_.base) + 1; n <= plan_.last; ++n) added.paths.push_back(plan_.path_of(n));
    }
    if (options_.into.empty()) {
      if (!are_listed) write_attributes(added);
      add_ranges(added);
    }
    write_attributes(added);
    result_.is_finished = true;
  }

  void write_attributes(const AddedOctaves& added) {
    if (!added.beside.empty() && added.paths.empty()) return;  // an image without octaves is none
    const fs::path name = target_ / attributes_file(plan_.image.zarr);
    const std::string text = image_metadata_with(store_, added);
    const InputFile there(name);
    std::string bytes(text.size(), '\0');
    if (there.is_open() && there.bytes() == text.size() && there.read(0, bytes.data(), bytes.size()) == bytes.size() &&
        bytes == text)
      return;
    write_whole(name, text, Existing::replaced);
  }

  void walk_coarsest() {
    const int from = std::max(plan_.base, plan_.top);
    const bool beside = !options_.into.empty() && plan_.base < plan_.top;
    workers_.clear();
    if (plan_.base > plan_.top)
      workers_.push_back(new_worker(store_, 0));
    else
      workers_.push_back(new_worker(target_, beside ? plan_.base + 1 : 0));
    UnitWorker& own = *workers_[0];
    done_items_ = 0, items_ = static_cast<std::size_t>(plan_.frames) * plan_.components.size();
    for (int frame = 0; frame < plan_.frames; ++frame)
      for (int field = 0; field < static_cast<int>(plan_.components.size()); ++field, ++done_items_) {
        item_ = {.frame = frame, .field = field};
        for (int n = plan_.top + 1; n <= plan_.last; ++n) facts_.set(n, {}, plan_.octaves[static_cast<std::size_t>(n)].chunks);
        facts_.set(plan_.top, {}, {});
        own.walk->set_item(frame, field, from);
        for (int n = plan_.top + 1; n <= plan_.base; ++n) {
          if (n < plan_.base || plan_.base == plan_.last) own.walk->read_facts(n, {}, blocks(n));
        }
        if (plan_.last > from) {
          for_each_index({}, blocks(plan_.last), [&](const VoxelIndex& at) {
            own.walk->emit_facts(plan_.last, at, own.walk->made(plan_.last, at));
            show(0.5);
          });
        }
        own.batch.finish();
        FileBatch batch;
        for (int n = plan_.top + 1; n <= plan_.last; ++n) {
          const PlannedOctave& o = plan_.octaves[static_cast<std::size_t>(n)];
          VoxelIndex end{};
          for (std::size_t a = 0; a < 3; ++a) end[a] = (o.chunks[a] + o.facts[a] - 1) / o.facts[a];
          checks_ ? compare_facts(own, n, {}, end) : files_->write_facts(n, frame, field, {}, end, facts_, batch);
        }
        batch.finish();
      }
    workers_.clear();
  }

  VoxelIndex blocks(int octave) const {
    const PlannedOctave& o = plan_.octaves[static_cast<std::size_t>(octave)];
    VoxelIndex count{};
    for (std::size_t a = 0; a < 3; ++a) count[a] = (o.dims[a] + o.block[a] - 1) / o.block[a];
    return count;
  }

  /// Of all voxels of a field, merged of the units'.
  Histogram histogram_of(int field) const {
    DyadicHistogram whole;
    for (std::int64_t n = 0; n < plan_.items(); ++n) {
      const UnitPlan::Item item = plan_.item(n);
      if (item.field != field) continue;
      const std::optional<DyadicHistogram> unit = files_->histogram(item);
      if (!unit) throw LoadError(target_.string() + ": has lost the histogram of a unit meanwhile; prepare it again");
      whole.merge(*unit);
    }
    const StoreField& of = contents_.fields[static_cast<std::size_t>(field)];
    return whole.classes(is_of_whole_numbers(of.type, of.components));
  }

  /// Ranges of the fields, and what octave 1 loses, from the facts of octave 0; their histograms.
  void add_ranges(AddedOctaves& added) {
    StoreReader reader(target_, options_.read, 1);
    if (!reader.contents().prepared) return;
    const PlannedOctave& o = plan_.octaves[0];
    VoxelIndex end{};
    for (std::size_t a = 0; a < 3; ++a) end[a] = (o.chunks[a] + o.facts[a] - 1) / o.facts[a];
    for (int field = 0; field < static_cast<int>(plan_.components.size()); ++field) {
      double low = INFINITY, high = -INFINITY, squares = 0.0, chunks = 0.0;
      for (int frame = 0; frame < plan_.frames; ++frame)
        for_each_index({}, end, [&](const VoxelIndex& at) {
          const StoreRead read = read_again(reader, {.frame = frame, .field = field, .facts = true, .at = at});
          if (read.state != ChunkState::present) return;
          const std::byte* next = reader.content(0).data();
          for_each_index({}, o.facts, [&](const VoxelIndex& inside) {
            ChunkFacts facts;
            std::memcpy(&facts, next, sizeof facts);
            next += sizeof facts;
            for (std::size_t a = 0; a < 3; ++a) {
              if (at[a] * o.facts[a] + inside[a] >= o.chunks[a]) return;
            }
            low = std::fmin(low, facts.min), high = std::fmax(high, facts.max);
            squares += facts.rms * facts.rms, chunks += 1.0;
          });
        });
      if (!(low <= high)) low = high = 0.0;
      added.ranges.push_back({low, high});
      added.lost.push_back(chunks > 0.0 ? std::sqrt(squares / chunks) : 0.0);
      added.histograms.push_back(histogram_of(field));
    }
  }

  fs::path store_, target_;
  const PrepareOptions& options_;
  bool checks_;
  StoreContents contents_;
  UnitPlan plan_;
  int threads_ = 1;
  std::unique_ptr<PreparedFiles> files_;
  std::vector<std::unique_ptr<UnitWorker>> workers_;
  UnitPlan::Item item_;
  FactsBox facts_;
  std::mutex mutex_;
  std::atomic<std::int64_t> chunks_read_ = 0;
  std::size_t done_items_ = 0, items_ = 1;
  PreparedStore result_;
  Clock::time_point begin_ = Clock::now();
};

}  // namespace

PreparedStore prepare_store(const fs::path& store, const PrepareOptions& options) {
  try {
    return Preparation(store, options, false).prepare();
  } catch (const LoadError& error) {
    const std::string problem = error.what();
    const bool named = problem.find(store.string()) == 0 || (!options.into.empty() && problem.find(options.into.string()) == 0);
    throw LoadError(named ? problem : store.string() + ": " + problem);
  }
}

PreparedStore check_prepared_store(const fs::path& store, const PrepareOptions& options) {
  try {
    if (!options.into.empty()) throw LoadError("--into has no check; check the store that it names by itself");
    return Preparation(store, options, true).check();
  } catch (const LoadError& error) {
    const std::string problem = error.what();
    throw LoadError(problem.find(store.string()) == 0 ? problem : store.string() + ": " + problem);
  }
}

}  // namespace palpa
