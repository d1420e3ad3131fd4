// TIFF and BigTIFF by libtiff: a folder of slices, or a file of one or several images.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <optional>

#include "first_bytes.h"
#include "palpa/base/load_error.h"
#include "palpa/base/printed.h"
#include "palpa/data/length_unit.h"
#include "source.h"
#include "tiff_file.h"
#include "tiff_names.h"

namespace palpa::reader {
namespace {

constexpr std::size_t most_slices = std::size_t{1} << 18;  // as of stores
constexpr std::int64_t most_channels = 32;                 // as of stores
// [bytes] Of rows read at once. More: more memory; less: more calls.
constexpr std::int64_t piece_bytes = 1 << 20;

std::optional<double> number_in(std::string_view text) {
  double number = 0;
  const auto read = std::from_chars(text.data(), text.data() + text.size(), number);
  return read.ec == std::errc{} && std::isfinite(number) ? std::optional(number) : std::nullopt;
}

/// Value of a line `key=value` of ImageJ; empty if absent.
std::string_view line_in(std::string_view text, std::string_view key) {
  while (!text.empty()) {
    const std::string_view line = text.substr(0, text.find('\n'));
    text.remove_prefix(std::min(line.size() + 1, text.size()));
    if (line.size() > key.size() && line.starts_with(key) && line[key.size()] == '=') return line.substr(key.size() + 1);
  }
  return {};
}

/// Facts about a stack in the text of its first image.
struct StackFacts {
  double x = 0, y = 0, z = 0;  ///< [own unit] of a voxel; 0: not given
  std::string unit;            ///< empty: of the resolution
  std::int64_t images = 0;     ///< 0: not given
  std::int64_t channels = 1, frames = 1;
  bool is_imagej = false;
};

StackFacts facts_of_imagej(std::string_view text) {
  StackFacts facts;
  facts.is_imagej = true;
  const auto count = [&](std::string_view key, std::int64_t otherwise) {
    const auto number = number_in(line_in(text, key));
    return number && *number >= 1 && *number < 1e9 ? static_cast<std::int64_t>(*number) : otherwise;
  };
  facts.images = count("images", 0), facts.channels = count("channels", 1), facts.frames = count("frames", 1);
  facts.z = std::abs(number_in(line_in(text, "spacing")).value_or(0.0));
  const std::string_view unit = line_in(text, "unit");
  if (unit != "pixel" && unit != "inch" && unit != "cm") facts.unit = unit == "\\u00B5m" ? "um" : std::string(unit);
  return facts;
}

StackFacts facts_of_ome(std::string_view text) {
  StackFacts facts;
  const std::size_t begin = text.find("<Pixels ");
  if (begin == std::string_view::npos) return facts;
  const std::string_view tag = text.substr(begin + 1, text.find('>', begin) - begin - 1);
  const auto number = [&](const char* key, double otherwise) { return number_in(attribute_in(tag, key)).value_or(otherwise); };
  const auto count = [&](const char* key) { return static_cast<std::int64_t>(std::clamp(number(key, 1), 1.0, 1e9)); };
  facts.channels = count("SizeC"), facts.frames = count("SizeT");
  std::string units[3];
  for (std::size_t a = 0; a < 3; ++a) {
    units[a] = attribute_in(tag, std::string("PhysicalSize") + "XYZ"[a] + "Unit");
    if (units[a].empty()) units[a] = "um";
  }
  if (units[0] != units[1] || units[0] != units[2]) return facts;
  facts.unit = units[0];
  facts.x = number("PhysicalSizeX", 0), facts.y = number("PhysicalSizeY", 0), facts.z = number("PhysicalSizeZ", 0);
  return facts;
}

class TiffSource final : public Source {
 public:
  explicit TiffSource(const protocol::Request& request) {
    header.format = "tiff", header.default_unit = "um";
    takes.layout = true;
    const ArrayLayout& layout = request.layout;
    if (layout.dims != ArrayLayout{}.dims || !layout.axes.empty() || !layout.components.empty())
      throw LoadError("says its own shape; leave dims, axes and components out");
    if (request.as == "vector") throw LoadError("holds one number a voxel, which is no vector; leave out as = \"vector\"");
    list_files(request.path);
    find_slices();
    add_unlisted();
    split_stack(request);
    raw_.type = image_.type;
    raw_.stride = {1, image_.columns, image_.columns * image_.rows};
    protocol::FieldHeader field;
    place(layout, field.grid);
    field.grid.dims = raw_.dims;
    protocol::VectorTurn none;
    keep(raw_, none, field, header.warnings);
    for (std::int64_t channel = 0; channel < channels_; ++channel) {
      field.name = channels_ == 1 ? "value" : "channel" + std::to_string(channel);
      header.fields.push_back(field);
    }
    header.reads_rows = true;
  }

  void read(const std::vector<std::uint32_t>& wanted, const std::vector<std::byte*>& to) override {
    const auto row_bytes = static_cast<std::int64_t>(size_of(header.fields[0].type)) * image_.columns;
    const std::int64_t at_once = std::max<std::int64_t>(piece_bytes / row_bytes, 1);
    std::vector<std::byte> piece(static_cast<std::size_t>(std::min(at_once, image_.rows) * row_bytes));
    for (std::size_t n = 0; n < to.size(); ++n)
      for (std::int64_t k = 0; k < raw_.dims[2]; ++k)
        for (std::int64_t j = 0; j < image_.rows; j += at_once) {
          const std::int64_t count = std::min(at_once, image_.rows - j);
          const auto frame = frame_ + static_cast<std::int64_t>(n / wanted.size());
          read_image_rows(image_number(frame, k, wanted[n % wanted.size()]), j, count, piece.data());
          put(to[n] + (k * image_.rows + j) * row_bytes, piece.data(), static_cast<std::uint64_t>(count * row_bytes));
        }
  }

  void read_rows(std::uint32_t field, std::int64_t slice, std::int64_t first, std::int64_t count, std::byte* to) override {
    read_image_rows(image_number(frame_, slice, field), first, count, to);
  }

 private:
  struct Slice {
    std::size_t file = 0;
    std::uint64_t place = 0;     ///< [bytes] of the image in its file
    std::uint64_t unlisted = 0;  ///< [bytes] of the numbers of another one, which is in no list; 0: the image itself
  };

  std::size_t image_number(std::int64_t frame, std::int64_t slice, std::uint32_t channel) const {
    return static_cast<std::size_t>((frame * raw_.dims[2] + slice) * channels_ + channel);
  }

  /// Rows of the image, with the numbers of its file.
  void read_stored_rows(const Slice& of, std::int64_t first, std::int64_t count, std::byte* to) {
    of.unlisted > 0 ? open_->read_unlisted_rows(image_, of.unlisted, first, count, to)
                    : open_->read_rows(image_, first, count, to);
  }

  void read_image_rows(std::size_t image, std::int64_t first, std::int64_t count, std::byte* to) {
    const Slice& of = slices_[image];
    try {
      if (!open_ || open_file_ != of.file) open_ = std::make_unique<TiffFile>(files[of.file]), open_file_ = of.file;
      open_->go_to(of.place);
      if (open_->image() != image_) throw LoadError("was changed while it was read; try again");
      if (kept_as_they_are(raw_, {}, header.fields[0])) return read_stored_rows(of, first, count, to);
      RawVoxels part = raw_;
      part.dims = {image_.columns, count, 1};
      room_.resize(static_cast<std::size_t>(image_.columns * count) * size_of(image_.type));
      read_stored_rows(of, first, count, room_.data());
      protocol::FieldHeader field = header.fields[0];
      field.grid.dims = part.dims;
      copy_voxels(room_.data(), part, {}, field, to);
    } catch (const LoadError& error) {
      throw with_name(of.file, error);
    }
  }

  /// The sentence of an error with the file's name, if it is one of several.
  LoadError with_name(std::size_t file, const LoadError& error) const {
    if (files.size() == 1) return error;
    return LoadError("has a slice '" + std::filesystem::path(files[file]).filename().string() + "' that " + error.what());
  }

  void list_files(const std::string& path) {
    std::error_code none;
    if (!std::filesystem::is_directory(path, none)) return files.push_back(path);
    const std::vector<std::string> names = tiff_names_in(path);
    if (names.empty()) throw LoadError("has no slices in TIFF; give a folder of a volume");
    if (names.size() > most_slices) throw LoadError("has more than 262144 slices; put fewer into a folder");
    for (const std::string& name : names) files.push_back((std::filesystem::path(path) / name).string());
    header.warnings = warnings_of_names(names);
  }

  void find_slices() {
    for (std::size_t f = 0; f < files.size(); ++f) {
      try {
        TiffFile file(files[f]);
        const TiffImage first = file.image();
        if (f == 0) image_ = first, take_facts(file);
        const std::vector<std::uint64_t> places = file.images();
        for (const std::uint64_t place : places) {
          file.go_to(place);
          add_slice({f, place}, file.image());
        }
        header.working_bytes = std::max(header.working_bytes, file.working_bytes());
      } catch (const LoadError& error) {
        throw with_name(f, error);
      }
    }
  }

  void add_slice(const Slice& slice, const TiffImage& image) {
    if (image.columns != image_.columns || image.rows != image_.rows)
      throw LoadError("has " + std::to_string(image.columns) + " × " + std::to_string(image.rows) +
                      " pixels where the first slice has " + std::to_string(image_.columns) + " × " +
                      std::to_string(image_.rows) + "; leave it out, or cut all to one size");
    if (image.type != image_.type) throw LoadError("has numbers of another type than the first slice; export all alike");
    if (slices_.size() >= most_slices) throw LoadError("is one of more than 262144 slices; put fewer together");
    slices_.push_back(slice);
  }

  void take_facts(const TiffFile& file) {
    const std::string text = file.description();
    if (text.starts_with("ImageJ="))
      facts_ = facts_of_imagej(text);
    else if (text.find("<OME") != std::string::npos)
      facts_ = facts_of_ome(text);
    const double x = file.resolution(TIFFTAG_XRESOLUTION), y = file.resolution(TIFFTAG_YRESOLUTION);
    if (facts_.x == 0 && x > 0 && y > 0) {
      facts_.x = 1 / x, facts_.y = 1 / y;
      if (facts_.unit.empty())
        facts_.unit = file.resolution_unit() == RESUNIT_CENTIMETER ? "cm" : file.resolution_unit() == RESUNIT_INCH ? "in" : "";
    }
    if (file.has_colour_table())
      header.warnings.push_back("has a table of colours, which is left out: its numbers are felt as they are stored");
    if (file.is_turned())
      header.warnings.push_back("is stored turned or mirrored (Orientation): columns and rows are taken as they are stored");
    first_voxel_ = file.first_voxel(), is_in_one_piece_ = file.is_in_one_piece(), file_bytes_ = file.bytes();
  }

  /// Slices of a large stack of ImageJ, which lists one image for all: the others lie behind it as bare numbers.
  void add_unlisted() {
    const auto there = static_cast<std::int64_t>(slices_.size());
    if (files.size() > 1 || facts_.images <= there) return;
    const std::uint64_t image_bytes = static_cast<std::uint64_t>(image_.columns * image_.rows) * size_of(image_.type);
    const std::uint64_t whole = first_voxel_ < file_bytes_ ? (file_bytes_ - first_voxel_) / image_bytes : 0;
    const bool is_bare = is_in_one_piece_ && there == 1;
    if (!is_bare || whole < static_cast<std::uint64_t>(facts_.images))
      throw LoadError("lacks " + std::to_string(facts_.images - (is_bare ? static_cast<std::int64_t>(whole) : there)) + " of " +
                      std::to_string(facts_.images) + " images; get the whole file, or export it again");
    for (std::int64_t n = 1; n < facts_.images; ++n)
      add_slice({0, slices_.front().place, first_voxel_ + static_cast<std::uint64_t>(n) * image_bytes}, image_);
  }

  /// Channels and moments of a stack: of ImageJ channels are nearest to each other, then slices, then moments.
  void split_stack(const protocol::Request& request) {
    const auto images = static_cast<std::int64_t>(slices_.size());
    const bool is_split = files.size() == 1 && (facts_.channels > 1 || facts_.frames > 1);
    if (is_split) {
      const std::string said =
          "is a stack of " + std::to_string(facts_.channels) + " channels and " + std::to_string(facts_.frames) + " moments";
      if (!facts_.is_imagej)
        throw LoadError(said + "; export one channel at one moment, or all by ImageJ (File > Save As > Tiff)");
      if (facts_.channels > images || facts_.frames > images || images % (facts_.channels * facts_.frames) != 0)
        throw LoadError(said + ", which " + std::to_string(images) + " images cannot be; get the whole file");
      if (facts_.channels > most_channels) throw LoadError(said + ", where up to 32 channels can be; export fewer");
      channels_ = facts_.channels;
    }
    const std::int64_t frames = is_split ? facts_.frames : 1;
    frame_ = choose_frames(request, frames);
    raw_.dims = {image_.columns, image_.rows, images / channels_ / frames};
  }

  void place(const ArrayLayout& layout, GridGeometry& grid) {
    Vec3 step = layout.spacing_m;
    if (step != Vec3{}) {
      header.length_unit = "m";
    } else {
      const auto unit = palpa::detail::length_unit(facts_.unit);
      const bool is_known = facts_.x > 0 && facts_.y > 0;
      step = is_known ? Vec3{facts_.x, facts_.y, facts_.z > 0 ? facts_.z : facts_.x} : Vec3{1, 1, 1};
      if (unit) header.length_unit = facts_.unit;
      if (!is_known) {
        header.warnings.push_back("says no size of its pixels: cubes of 1 are taken (spacing_m = [x, y, z] takes others)");
      } else if (facts_.z <= 0 && raw_.dims[2] > 1) {
        header.warnings.push_back("says no distance of its slices: that of its pixels is taken, " +
                                  palpa::detail::text("%.6g", facts_.x) + (unit ? " " + unit->name : "") +
                                  " (spacing_m = [x, y, z] takes others)");
      }
    }
    grid.index_to_world_m = {{{step.x, 0, 0}, {0, step.y, 0}, {0, 0, step.z}}};
    grid.origin_m = layout.origin_m.value_or(Vec3{});
  }

  std::vector<Slice> slices_;
  TiffImage image_;
  StackFacts facts_;
  std::uint64_t first_voxel_ = 0, file_bytes_ = 0;  ///< [bytes] of the first image; of its file
  bool is_in_one_piece_ = false;                    ///< the first image
  std::int64_t channels_ = 1, frame_ = 0;           ///< [1]; the first frame to read
  RawVoxels raw_;
  std::unique_ptr<TiffFile> open_;
  std::size_t open_file_ = 0;
  std::vector<std::byte> room_;
};

}  // namespace

std::unique_ptr<Source> open_tiff(const protocol::Request& request) { return std::make_unique<TiffSource>(request); }

}  // namespace palpa::reader
