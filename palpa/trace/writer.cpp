#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <optional>
#include <system_error>
#include <utility>

#include "palpa/base/new_file.h"
#include "palpa/trace/columns.h"
#include "palpa/trace/csv.h"
#include "palpa/trace/trace.h"
#include "palpa/trace/trace_toml.h"
#include "palpa/trace/windows.h"

namespace palpa {

namespace fs = std::filesystem;

namespace {

// A file's rows are written in blocks of this size. More: more is lost when the process is killed; less: more system calls.
constexpr std::size_t buffer_bytes = std::size_t{1} << 16;

LoadError cannot_write(const fs::path& path, int error) {
  const bool full = error == ENOSPC || error == EDQUOT || error == EFBIG;
  return LoadError(path.string() + ": cannot be written (" + std::generic_category().message(error) + "); " +
                   (full ? "make room, or choose another folder" : "choose a folder that can be written"));
}

// A facet without force has no part in its balance; its row is omitted.
bool is_idle_facet(const PlacedPrimitive& placed) {
  return placed.primitive.kind == PrimitiveKind::corner && placed.force_n == Vec3{};
}

// Buffered file of rows, under its name from the start: a recording must survive a crash. Always a new one, so never a link's
// target. Its destructor closes it without writing the buffer.
class OutputFile {
 public:
  explicit OutputFile(fs::path path) : path_(std::move(path)) {
    descriptor_ = ::open(path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (descriptor_ < 0) throw cannot_write(path_, errno);
    buffer_.reserve(buffer_bytes + 4096);
  }
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;
  ~OutputFile() {
    if (descriptor_ >= 0) ::close(descriptor_);
  }

  /// Buffer for appending rows.
  std::string& rows() noexcept { return buffer_; }
  void write_if_long() {
    if (buffer_.size() >= buffer_bytes) write();
  }
  void write() {
    std::size_t done = 0;
    while (done < buffer_.size()) {
      const ssize_t wrote = ::write(descriptor_, buffer_.data() + done, buffer_.size() - done);
      if (wrote < 0 && errno == EINTR) continue;
      if (wrote < 0) {
        const int error = errno;
        buffer_.clear();
        throw cannot_write(path_, error);
      }
      done += static_cast<std::size_t>(wrote);
    }
    buffer_.clear();
  }
  void close() {
    write();
    const int descriptor = std::exchange(descriptor_, -1);
    if (::close(descriptor) != 0) throw cannot_write(path_, errno);
  }

 private:
  fs::path path_;
  int descriptor_ = -1;
  std::string buffer_;
};

// Atomic: a reader finds the old trace.toml or the new one, never half of it.
void replace_header(const fs::path& folder, const TraceHeader& header) {
  detail::write_whole(folder / "trace.toml", detail::header_to_toml(header), detail::Existing::replaced);
}

void create(const fs::path& folder) {
  if (::mkdir(folder.c_str(), 0777) == 0) return;
  const int error = errno;
  const std::string place = folder.string() + ": ";
  if (error == EEXIST) throw LoadError(place + "exists already; name a new folder for the trace");
  if (error == ENOENT) throw LoadError(place + "its parent folder does not exist; make that first");
  throw cannot_write(folder, error);
}

}  // namespace

class TraceWriter::Files {
 public:
  Files(fs::path where, const TraceHeader& what, std::vector<std::string> modes_by_number, std::vector<TracedField> in_octaves)
      : folder(std::move(where)),
        header(what),
        mode_names(std::move(modes_by_number)),
        octaves(std::move(in_octaves)),
        sums_written(octaves.size()),
        ticks(begin(detail::ticks_table())),
        modes(begin(detail::modes_table())),
        events(begin(detail::events_table())),
        timing(begin(detail::timing_table())) {
    header.complete = false;
    if (!header.primitives) return;
    balances = begin(detail::balances_table());
    primitives = begin(detail::primitives_table());
  }

  detail::TraceKind kind() const { return {header.has_tool, header.has_octaves}; }

  // File of a table with its header line.
  template <class Row>
  std::unique_ptr<OutputFile> begin(const detail::Table<Row>& table) const {
    auto file = std::make_unique<OutputFile>(folder / table.file);
    const std::vector<std::string> names = table.of(kind()).names();
    for (std::size_t i = 0; i < names.size(); ++i) file->rows() += (i ? "," : "") + names[i];
    file->rows() += '\n';
    return file;
  }

  template <class Row>
  void add(OutputFile& file, const detail::Table<Row>& table, const Row& row) const {
    table.of(kind()).write(row, file.rows());
    file.write_if_long();
  }

  // Adds to a file that is created with its first row.
  template <class Row>
  void add_to(std::unique_ptr<OutputFile>& file, const detail::Table<Row>& table, const Row& row) const {
    if (!file) file = begin(table);
    add(*file, table, row);
  }

  template <class Action>
  void each(Action action) {
    for (OutputFile* file : {modes.get(), events.get(), break_throughs.get(), timing.get(), balances.get(), primitives.get(),
                             works.get(), windows.get(), chunks.get(), ticks.get()}) {
      if (file) action(*file);
    }
  }

  std::string_view mode_name(std::int64_t number) const {
    return number >= 0 && number < static_cast<std::int64_t>(mode_names.size()) ? std::string_view(mode_names[number])
                                                                                : "session";
  }

  // After a failure rows are missing: nothing more is written, and `finish` throws.
  template <class Action>
  void guarded(Action action) {
    if (failure) throw LoadError(*failure);
    try {
      action();
    } catch (const LoadError& error) {
      failure = error.what();
      throw;
    }
  }

  void put_event(std::int64_t tick, double t_s, std::string_view kind, std::string_view subject, std::string_view value) {
    add(*events, detail::events_table(), {.tick = tick, .t_s = t_s, .kind = kind, .subject = subject, .value = value});
  }

  void put_window(const TickFrame& frame) {
    const auto of = std::ranges::find(octaves, frame.laid.of, &TracedField::octaves);
    if (of != octaves.end())
      add_to(windows, detail::windows_table(), {frame.tick, of->volume, of->field, frame.laid, of->frame});
  }
  // Chunks read since the last call.
  void put_chunks() {
    for (std::size_t n = 0; n < octaves.size(); ++n) {
      for (const ChunkSum& sum : octaves[n].octaves->shape().source->sums_from(sums_written[n])) {
        add_to(chunks, detail::chunks_table(), {octaves[n].volume, octaves[n].field, sum, octaves[n].frame});
        ++sums_written[n];
      }
    }
  }

  bool has_checksums() const {
    return std::ranges::all_of(header.data_files, [](const SourceFile& file) { return file.sha256.is_known(); });
  }
  // A killed recording is felt again only with them.
  void put_checksums() {
    if (!lacks_checksums || !has_checksums()) return;
    replace_header(folder, header);
    lacks_checksums = false;
  }

  void note_guard(const TickFrame& frame) {
    const Command& command = frame.command;
    if (command.guard == last_guard && command.cause == last_cause) return;
    const bool fault = command.guard == GuardState::fault;
    const char* why = command.guard == GuardState::limited  ? "the force is above the limit"
                      : command.guard == GuardState::damped ? "more energy came out than went in"
                                                            : format_cause(command.cause);
    put_event(frame.tick, frame.t_s, fault ? "fault" : "guard", fault ? "guard" : name_of(command.guard), why);
    last_guard = command.guard;
    last_cause = command.cause;
  }
  void note_unfelt(const TickFrame& frame) {
    unfelt_j += frame.command.unfelt_j;
    if (unfelt_j > told_unfelt_j && !std::exchange(has_told_unfelt, true))
      put_event(frame.tick, frame.t_s, "warning", "session",
                "turning the handle brings in energy: the device senses turns and drives no torque against them");
  }

  void put_balances(std::int64_t tick, std::span<const SubStep> sub_steps, std::span<const PlacedPrimitive> placed) {
    for (std::size_t i = 0; i < sub_steps.size(); ++i) {
      SubStep step = sub_steps[i];
      const auto own = placed.subspan(step.first_primitive, step.primitives);
      const auto number = static_cast<std::int64_t>(i);
      step.primitives -= static_cast<std::uint32_t>(std::count_if(own.begin(), own.end(), is_idle_facet));
      add(*balances, detail::balances_table(), {tick, number, step});
      for (const PlacedPrimitive& one : own) {
        if (is_idle_facet(one)) continue;
        const Primitive& row = one.primitive;
        const auto stiffness = row.is_elastic() ? std::optional(row.stiffness_n_per_m) : std::nullopt;
        const std::optional<double> captured = one.captured.any() ? std::optional(one.captured.value) : std::nullopt;
        const std::string_view mode = mode_name(one.primitive.id.mode);
        const bool is_friction = one.plane_slot >= 0;
        const auto coefficient = is_friction ? std::optional(one.coefficient) : std::nullopt;
        const auto plane = is_friction ? std::optional(std::int64_t{one.plane_slot}) : std::nullopt;
        add(*primitives, detail::primitives_table(), {tick, number, mode, one, captured, stiffness, coefficient, plane});
        if (one.carried_m == Vec3{}) continue;
        add_to(works, detail::works_table(), {tick, number, mode, one, work_j(step, one)});
      }
    }
  }

  fs::path folder;
  TraceHeader header;
  std::vector<std::string> mode_names;
  std::vector<TracedField> octaves;
  std::vector<std::size_t> sums_written;  // by field
  std::unique_ptr<OutputFile> ticks, modes, events, break_throughs, timing, balances, primitives, works, windows, chunks;
  double unfelt_j = 0.0;         // since the begin
  bool lacks_checksums = false;  // in trace.toml: they were not computed yet
  bool has_told_unfelt = false;
  GuardState last_guard = GuardState::pass;
  GuardCause last_cause = GuardCause::none;
  std::optional<std::string> failure;
  bool finished = false;
};

TraceWriter::TraceWriter(const fs::path& folder, const TraceHeader& header, const std::string& scene_text,
                         std::vector<std::string> mode_names)
    : TraceWriter(folder, header, scene_text, std::move(mode_names), std::vector<TracedField>{}) {}

TraceWriter::TraceWriter(const fs::path& folder, const TraceHeader& header, const std::string& scene_text,
                         std::vector<std::string> mode_names, std::vector<TracedField> octaves) {
  create(folder);
  try {
    files_ = std::make_unique<Files>(folder, header, std::move(mode_names), std::move(octaves));
    detail::write_whole(folder / "scene.toml", scene_text, detail::Existing::refused);
    flush();
    // trace.toml is written last: it marks a folder as a trace.
    files_->lacks_checksums = !files_->has_checksums();
    replace_header(folder, files_->header);
  } catch (...) {
    files_.reset();
    std::error_code ignored;
    fs::remove_all(folder, ignored);
    throw;
  }
}

TraceWriter::~TraceWriter() {
  if (files_->finished || files_->failure) return;
  try {
    flush();
  } catch (const std::exception&) {
    // A destructor cannot throw: without `finish` the trace is marked incomplete.
  }
}

void TraceWriter::add_note(const std::string& note) { files_->header.notes.push_back(note); }
bool TraceWriter::records_primitives() const noexcept { return files_->header.primitives; }

void TraceWriter::append(const TickFrame& frame, std::span<const ModeForce> modes, std::span<const SubStep> sub_steps,
                         std::span<const PlacedPrimitive> placed, std::span<const SessionEvent> events) {
  Files& files = *files_;
  files.guarded([&] {
    files.add(*files.ticks, detail::ticks_table(), frame);
    files.add(*files.timing, detail::timing_table(), frame);
    if (frame.laid.of) files.put_window(frame);
    for (std::size_t i = 0; i < modes.size(); ++i) {
      files.add(*files.modes, detail::modes_table(), {frame.tick, files.mode_name(static_cast<std::int64_t>(i)), modes[i]});
    }
    if (files.header.primitives) files.put_balances(frame.tick, sub_steps, placed);
    for (const SessionEvent& event : events) {
      std::string value;
      if (event.text) {
        value = event.text;
      } else {
        detail::put_number(value, event.value);
      }
      const std::string_view mode = files.mode_name(event.mode);
      files.put_event(frame.tick, frame.t_s, name_of(event.kind), mode, value);
      if (event.kind == SessionEventKind::break_through) {
        files.add_to(files.break_throughs, detail::break_throughs_table(), {frame.tick, frame.t_s, mode, event});
      }
    }
    if (frame.command.snap_n > 0.0) {
      std::string value;
      detail::put_number(value, frame.command.snap_n);
      files.put_event(frame.tick, frame.t_s, "snap", "proxy", value);
    }
    files.note_unfelt(frame);
    if ((frame.circumstances & bit_of(Circumstance::new_scene)) != 0) {
      files.put_event(frame.tick, frame.t_s, "scene", "session", "another scene is felt from here on");
    }
    files.note_guard(frame);
  });
}

void TraceWriter::append_event(std::int64_t tick, double t_s, const std::string& kind, const std::string& subject,
                               const std::string& value) {
  files_->guarded([&] { files_->put_event(tick, t_s, kind, subject, value); });
}

void TraceWriter::flush() {
  files_->guarded([&] {
    files_->put_chunks();
    files_->put_checksums();
    files_->each([](OutputFile& file) { file.write(); });
  });
}

void TraceWriter::finish() {
  Files& files = *files_;
  if (files.finished) return;
  files.guarded([&] {
    files.put_chunks();
    files.each([](OutputFile& file) { file.close(); });
    files.header.complete = true;
    for (SourceFile& file : files.header.data_files) file.sha256 = file.sha256.text();
    replace_header(files.folder, files.header);
  });
  files.finished = true;
}

}  // namespace palpa
