// DICOM series as volumes. From vtk-dicom only headers: it averages spacings, swaps those of rows and columns, ignores gaps.
#include <algorithm>
#include <cstring>
#include <filesystem>
#include <future>
#include <limits>
#include <memory>
#include <mutex>
#include <set>
#include <utility>

#include "dicom_files.h"
#include "dicom_slices.h"
#include "source.h"

namespace palpa::reader {
namespace {

class DicomSource : public Source {
 public:
  explicit DicomSource(const protocol::Request& request) : images_(request.path, request.memory, request.max_bytes) {
    header.format = "dicom";
    takes.series = true;
    header.default_unit = "mm";
    if (request.as == "vector") throw LoadError("is DICOM, whose images hold no vectors; leave out as = \"vector\"");
    if (images_.slices().empty()) {
      throw LoadError(images_.refused().empty() ? "has no DICOM image that can be read; check that the files are whole"
                                                : images_.refused().begin()->first);
    }
    for (const auto& [why, count] : images_.refused()) {
      header.warnings.push_back(std::to_string(count) + (count == 1 ? " file is" : " files are") + " left out: each " + why);
    }
    if (const int count = images_.damaged(); count > 0) {
      header.warnings.push_back(std::to_string(count) + (count == 1 ? " DICOM file is" : " DICOM files are") +
                                " left out: no image, or damaged");
    }
    std::vector<Slice> stack = chosen(stacks_of(images_.slices()), request.series);
    if (images_.slices().size() == 1) header.warnings.push_back("holds one slice; give its folder to read all its series");
    numbers_ = common_numbers(stack);
    header.medical_frame = stack.front().placed;
    header.modality = images_.modality(stack.front());
    header.frame_of_reference = stack.front().space;
    if (stack.front().spaced) header.length_unit = "mm";
    // Clears bits outside of the stored ones, unless the padding value needs them.
    masked_ = std::ranges::all_of(stack, [](const Slice& s) {
      return !s.padding || (s.padding->front() >= s.least() && s.padding->back() <= s.greatest());
    });
    volume_ = arranged(std::move(stack), header.warnings);
    header.labels = images_.segments(slices().front());
    if (request.frame == -1 && images_.is_binary(slices().front())) segments_ = segments_of(volume_);
    const std::size_t frames = segments_.empty() ? volume_.frames.size() : 1;
    frame_ = static_cast<std::size_t>(choose_frames(request, static_cast<std::int64_t>(frames)));
    if (request.frame < 0 && request.frame != VolumeRequest::all_frames && frames > 1 && !volume_.differ.empty()) {
      header.warnings.push_back("has frames that differ in " + volume_.differ);
    }
    // Middle slice, unless it was inserted.
    const Slice& middle = slices()[slices().size() / 2];
    const Slice& shown = middle.blank ? *std::ranges::find(slices(), false, &Slice::blank) : middle;
    header.scan = images_.scan(shown);

    protocol::FieldHeader field;
    field.name = "value";
    field.unit = images_.unit(shown);
    field.type = segments_.empty() ? numbers_.type : std::ranges::max(segments_) < 256 ? VoxelType::uint8 : VoxelType::uint16;
    field.grid = volume_.grid;
    field.scale = numbers_.scale, field.offset = numbers_.offset;
    header.fields.push_back(field);

    const std::size_t frames_used = segments_.empty() ? static_cast<std::size_t>(frames_read) : segments_.size();
    for (std::size_t n = 0; n < frames_used; ++n) {
      for (const Slice& slice : volume_.frames[frame_ + n]) {
        if (slice.blank) continue;
        if (files.empty() || files.back() != images_.name(slice)) files.push_back(images_.name(slice));
        header.working_bytes = std::max(header.working_bytes, 2 * images_.voxel_bytes(slice) + images_.stored_bytes(slice));
      }
    }
    header.working_bytes = (in_two_threads() ? 2 : 1) * (header.working_bytes + kept_bytes());
    if (volume_.resampled || !segments_.empty()) header.working_bytes += 4 * slices().size() * kept_bytes();
  }

  void read(const std::vector<std::uint32_t>&, const std::vector<std::byte*>& to) override {
    Loaded file;
    if (!segments_.empty()) return read_segments(file, to.front());
    for (std::byte* const frame : to) {
      read_frame(file, frame);
      ++frame_;
    }
  }

 private:
  /// Last file read, if its numbers are converted.
  struct Loaded {
    int file = -1;
    std::unique_ptr<std::byte[]> frames;  ///< takes no memory until the library has checked the file's length and writes
  };

  /// Number of each frame's segment; empty if these are not all there, different and from 1 to 65535.
  static std::vector<int> segments_of(const Arranged& volume) {
    std::vector<int> segments;
    for (const std::vector<Slice>& frame : volume.frames) {
      for (const Trait& trait : frame.front().traits) {
        const double number = attribute(trait.attribute).name == "segment" && !trait.numbers.empty() ? trait.numbers[0] : 0.0;
        if (number >= 1.0 && number <= 65535.0) segments.push_back(static_cast<int>(number));
      }
    }
    const std::set<int> different(segments.begin(), segments.end());
    return different.size() == volume.frames.size() ? segments : std::vector<int>();
  }

  /// Reads all segments as one map of labels; where segments overlap, the last is kept.
  void read_segments(Loaded& file, std::byte* to) {
    const std::uint64_t count = slices().size() * slices().front().pixels();
    std::vector<std::byte> of_segment(slices().size() * kept_bytes());
    std::vector<std::uint16_t> labels(count, 0);
    std::uint64_t overlaps = 0;
    const auto to_file = std::exchange(
        put, [](std::byte* place, const std::byte* from, std::uint64_t bytes) { std::memcpy(place, from, bytes); });
    for (const int segment : segments_) {
      read_frame(file, of_segment.data());
      protocol::with_type(numbers_.type, [&](auto value) {
        const auto* const in = reinterpret_cast<const decltype(value)*>(of_segment.data());
        for (std::uint64_t v = 0; v < count; ++v) {
          if (in[v] == 0) continue;
          overlaps += labels[v] != 0;
          labels[v] = static_cast<std::uint16_t>(segment);
        }
      });
      ++frame_;
    }
    put = to_file;
    std::vector<std::uint8_t> bytes;
    if (header.fields[0].type == VoxelType::uint8) bytes.assign(labels.begin(), labels.end());
    put(to, reinterpret_cast<const std::byte*>(bytes.empty() ? static_cast<const void*>(labels.data()) : bytes.data()),
        bytes.empty() ? 2 * count : count);
    if (overlaps > 0)
      warnings.push_back("has segments that overlap in " + std::to_string(overlaps) +
                         " voxels, in which the last is read (frame = N reads one segment)");
  }

  const std::vector<Slice>& slices() const { return volume_.frames[frame_]; }
  std::uint64_t kept_bytes() const { return slices().front().pixels() * palpa::size_of(numbers_.type); }

  /// True if two threads each read half of the slices: writing to shared memory takes longer than reading most slices. A file
  /// of several slices is loaded once, by one thread.
  bool in_two_threads() const {
    return !volume_.resampled && files.size() == static_cast<std::size_t>(frames_read) * slices().size() && slices().size() > 1;
  }

  /// Reads a slice in the kept number type. One thread at a time, because the libraries are not thread-safe.
  void read_slice(const Slice& slice, Loaded& loaded, std::byte* kept) {
    const std::scoped_lock alone(libraries_);
    if (slice.blank) {
      const std::vector<std::byte> zeros(slice.pixels() * size_of(slice.type));
      return convert(zeros.data(), slice, kept);
    }
    if (images_.voxel_bytes(slice) == kept_bytes() && kept_as_it_is(slice)) return load(slice, kept);
    if (slice.file != loaded.file) {
      loaded.frames = std::make_unique_for_overwrite<std::byte[]>(images_.voxel_bytes(slice));
      load(slice, loaded.frames.get());
      loaded.file = slice.file;
    }
    convert(loaded.frames.get() + static_cast<std::size_t>(slice.frame) * slice.pixels() * size_of(slice.type), slice, kept);
  }

  void read_frame(Loaded& file, std::byte* to) {
    if (volume_.resampled) {
      const auto own = std::make_unique_for_overwrite<std::byte[]>(slices().size() * kept_bytes());
      for (std::size_t n = 0; n < slices().size(); ++n) read_slice(slices()[n], file, own.get() + n * kept_bytes());
      return resample(own.get(), to);
    }
    if (!in_two_threads()) return copy(0, slices().size(), file, to);
    const std::size_t middle = slices().size() / 2;
    std::future<void> other = std::async(std::launch::async, [&] {
      Loaded of_other;
      copy(0, middle, of_other, to);
    });
    copy(middle, slices().size(), file, to);
    other.get();
  }

  /// Reads the slices [first, last) to `to`.
  void copy(std::size_t first, std::size_t last, Loaded& file, std::byte* to) {
    const auto kept = std::make_unique_for_overwrite<std::byte[]>(kept_bytes());
    for (std::size_t n = first; n < last; ++n) {
      read_slice(slices()[n], file, kept.get());
      put(to + n * kept_bytes(), kept.get(), kept_bytes());
    }
  }

  void load(const Slice& slice, std::byte* to) {
    try {
      images_.load(slice, masked_, to);
    } catch (const LoadError& error) {
      throw LoadError("has a file, '" + std::filesystem::path(images_.name(slice)).filename().string() + "', that " +
                      error.what());
    }
  }

  /// Stack with the most voxels, of the requested series or of all; warns of omitted stacks.
  std::vector<Slice> chosen(std::vector<std::vector<Slice>> stacks, const std::string& series) {
    struct Series {
      std::string uid, words;
      std::size_t slices = 0;
    };
    std::vector<Series> all;
    for (const auto& stack : stacks) {
      auto known = std::ranges::find(all, stack.front().series, &Series::uid);
      if (known == all.end()) {
        known = all.insert(all.end(), {stack.front().series, images_.series_words(stack.front())});
      }
      known->slices += stack.size();
    }
    const auto listed = [&](const std::string& but) {
      std::string text;
      for (const Series& s : all) {
        if (s.uid == but) continue;
        text += (text.empty() ? "'" : "; '") + s.uid + "' (" + s.words + ", " + std::to_string(s.slices) + " slices)";
        if (text.size() > 3000) return text + " …";
      }
      return text;
    };
    for (const Series& s : all) header.series.push_back({s.uid, s.words, static_cast<std::int64_t>(s.slices)});
    const auto largest = std::ranges::max_element(stacks, {}, [&](const std::vector<Slice>& s) {
      return series.empty() || s.front().series == series ? s.front().pixels() * s.size() : 0;
    });
    const std::string taken = largest->front().series;
    if (!series.empty() && taken != series) throw LoadError("has no series '" + series + "'; it has " + listed(""));
    if (all.size() > 1 && series.empty()) {
      header.warnings.push_back("holds " + std::to_string(all.size()) + " series: the largest, '" + taken +
                                "', is read (series = \"…\" takes another: " + listed(taken) + ")");
    }
    const std::size_t of_series = std::ranges::find(all, taken, &Series::uid)->slices;
    if (of_series > largest->size()) {
      header.warnings.push_back("has slices of different sizes, spacings, orientations or types of numbers: " +
                                std::to_string(of_series - largest->size()) + " of " + std::to_string(of_series) +
                                " are left out");
    }
    return std::move(*largest);
  }

  bool kept_as_it_is(const Slice& slice) const {
    const ToKept kept = to_kept(slice, numbers_);
    bool same = false;
    protocol::with_type(slice.type, [&](auto from) {
      protocol::with_type(numbers_.type, [&](auto to) { same = std::is_same_v<decltype(from), decltype(to)>; });
    });
    return same && kept.factor == 1 && kept.shift == 0 && !slice.padding;
  }

  void convert(const std::byte* raw, const Slice& slice, std::byte* to) const {
    const ToKept kept = to_kept(slice, numbers_);
    protocol::with_type(slice.type, [&](auto raw_value) {
      using Raw = decltype(raw_value);
      const auto* in = reinterpret_cast<const Raw*>(raw);
      protocol::with_type(numbers_.type, [&](auto kept_value) {
        using Kept = decltype(kept_value);
        auto* out = reinterpret_cast<Kept*>(to);
        for (std::uint64_t i = 0; i < slice.pixels(); ++i) {
          out[i] = static_cast<Kept>(static_cast<double>(in[i]) * kept.factor + kept.shift);
        }
        if constexpr (std::is_floating_point_v<Kept>) {
          if (!slice.padding) return;
          const auto [from, until] = *slice.padding;
          for (std::uint64_t i = 0; i < slice.pixels(); ++i) {
            const auto value = static_cast<double>(in[i]);
            if (value >= from && value <= until) out[i] = std::numeric_limits<Kept>::quiet_NaN();
          }
        }
      });
    });
  }

  /// Interpolates layers linearly between two slices; whole numbers are rounded.
  void resample(const std::byte* slices_kept, std::byte* to) const {
    const std::uint64_t count = slices().front().pixels();
    protocol::with_type(numbers_.type, [&](auto value) {
      using Kept = decltype(value);
      auto* out = reinterpret_cast<Kept*>(to);
      for (const double at : volume_.layer_at) {
        const auto below = std::min(static_cast<std::size_t>(at), slices().size() - 2);
        const double share = at - static_cast<double>(below);
        const Kept* a = reinterpret_cast<const Kept*>(slices_kept) + below * count;
        const Kept* b = a + count;
        for (std::uint64_t i = 0; i < count; ++i) {
          // On a slice only its own numbers count: NaN (padding) of the other slice would spread even with weight 0.
          const auto blend = share == 0   ? static_cast<double>(a[i])
                             : share == 1 ? static_cast<double>(b[i])
                                          : (1 - share) * static_cast<double>(a[i]) + share * static_cast<double>(b[i]);
          *out++ = static_cast<Kept>(std::is_floating_point_v<Kept> ? blend : std::round(blend));
        }
      }
    });
  }

  DicomFiles images_;
  Arranged volume_;
  std::size_t frame_ = 0;      ///< read next
  std::vector<int> segments_;  ///< numbers, of each frame; empty: no map of labels
  Numbers numbers_;
  std::mutex libraries_;
  bool masked_ = true;  ///< clears bits outside of the stored ones
};

}  // namespace

std::unique_ptr<Source> open_dicom(const protocol::Request& request) { return std::make_unique<DicomSource>(request); }

}  // namespace palpa::reader
